"""The sample of a person whose path is unknown."""

from __future__ import annotations

from math import cos, hypot, radians, sin

import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from sample_runs import crossing, sample_of

SPEED = 1.6
"""m/s of the person."""


def turned(time: float) -> float:
    """Return by how many degrees the arm has turned: from 0.2 s on, 360 deg/s^2 up to 90 deg/s, until 90 degrees."""
    since = min(max(time - 0.2, 0.0), 1.25)
    if since < 0.25:
        return 180.0 * since**2
    return 90.0 * (since - 0.125) if since < 1.0 else 90.0 - 180.0 * (1.25 - since) ** 2


def out_of_reach(time: float, curtain: float) -> float:
    """Return by how much (m) the arm is out of reach of a person who came through a curtain at 0 s."""
    turn = radians(turned(time))
    along = min(max(curtain * cos(turn), 0.0), 1.2)
    nearest = hypot(curtain - along * cos(turn), along * sin(turn))
    return nearest - 0.08 - 0.4 - SPEED * time


def test_the_near_curtain_lets_a_person_reach_the_arm_when_the_closed_form_says() -> None:
    cell = sample_of("person_at_cell")
    begin, away, again = (
        crossing(lambda time: out_of_reach(time, 2.4), *sides, 0.0) for sides in ((0.0, 0.7), (0.7, 1.0), (1.0, 1.3))
    )
    assert turned(away) < turned(again) < 90.0
    assert cell.says("sqrt(2.4^2 + 1.2^2 - 2 x 2.4 x 1.2 cos a) m from the curtain, less 0.08 and 0.4 m")
    assert cell.says(f"person_near and arm: possible from {begin:.6f} s, when the arm has begun to turn")
    assert cell.says(f"From {away:.6f} s to {again:.6f} s the arm is out of reach")
    told = cell.pair("arm|person_near")
    assert (told["verdict"], told["contacts"]) == ("possible", [])
    assert told["possible"] == [pytest.approx([begin, away], abs=1e-6), pytest.approx([again, 3.0], abs=1e-6)]
    assert told["possible"][0][0] <= begin + 1e-9
    assert told["possible"][0][1] >= away - 1e-9
    assert told["possible"][1][0] <= again + 1e-9


def test_the_far_curtain_keeps_a_person_out_until_the_arm_has_long_been_still() -> None:
    cell = sample_of("person_at_cell")
    reached = (4.2 - 0.08 - 0.4) / SPEED
    still = 0.2 + 1.25
    assert cell.says(f"person_far and arm: clear until {reached:.3f} s, which is (4.2 - 0.08 - 0.4) / 1.6")
    assert cell.says(f"the arm has been still for {reached - still:.3f} s")
    assert cell.says(f"stands still from {still:.2f} s on")
    assert crossing(lambda time: out_of_reach(time, 4.2), 0.0, 3.0, 0.0) == pytest.approx(reached, abs=1e-12)
    told = cell.pair("arm|person_far")
    assert told["possible"] == [pytest.approx([reached, 3.0], abs=1e-6)]
    assert told["possible"][0][0] <= reached + 1e-9


def test_viewers_are_told_that_contact_is_possible_while_it_is_and_how_near_it_is_before() -> None:
    cell = sample_of("person_at_cell")
    possible = cell.pair("arm|person_near")["possible"]
    seen = {True: 0, False: 0}
    with cell.logs[0].open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for _, channel, record, message in reader.iter_decoded_messages(["/viz/contacts", "/viz/clearance"]):
            time = 1e-9 * record.log_time
            if min(abs(time - edge) for span in possible for edge in span) < 1e-6:
                continue
            now = any(begin < time < end for begin, end in possible)
            drawn = [one for one in message.entities if one.id == "arm|person_near"]
            assert len(drawn) == (now if channel.topic == "/viz/contacts" else not now)
            for entity in drawn:
                words = [text.text for text in entity.texts]
                assert (words == ["possible"]) is now
                seen[now] += 1
    assert min(seen.values()) > 20
