"""Tries that fail grow rare, and come back when one pays."""

from closecall.scheduler.pairs.backoff import MOST_PASSED, Backoff


def passed_until_due(attempts: Backoff) -> int:
    """Return how many chances pass until one is to be tried."""
    return next(count for count in range(100) if attempts.due())


def test_the_first_chance_is_tried_and_more_pass_with_each_failure():
    attempts, passed = Backoff(), []
    for _ in range(6):
        passed.append(passed_until_due(attempts))
        attempts.learn(False)
    assert passed == [0, 1, 3, 7, 7, 7]
    assert max(passed) == MOST_PASSED


def test_once_a_try_pays_every_chance_is_tried():
    attempts = Backoff()
    for _ in range(5):
        passed_until_due(attempts)
        attempts.learn(False)
    passed_until_due(attempts)
    attempts.learn(True)
    for _ in range(3):
        assert attempts.due()
        attempts.learn(True)
