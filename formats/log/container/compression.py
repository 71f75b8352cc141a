"""Chunks uncompressed, in no more memory than they say that they take, whatever their bytes say."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import lz4.frame
import zstandard

from ...scene.text.errors import quoted

# Of a zstd frame, bytes, at least: what its compressor may have looked back by, whatever the size of its chunk.
_WINDOW_BYTES = 2**27

# So much is uncompressed at a time, or this share of the whole where that is more.
_PIECE_BYTES = 2**20
_PIECES = 8


def uncompressed(kind: str, data: bytes, size: int) -> bytes:
    """Return what a chunk of `size` bytes holds.

    Args:
        kind: of the compression, empty for none.
        data: compressed.
        size: what the chunk says that it holds; nothing is made that is larger.

    Raises:
        ValueError: for a chunk that is not as it says.
    """
    if kind not in _READERS:
        raise ValueError(f"a chunk is compressed by {quoted(kind)}, which is unknown")
    pieces: list[bytes] = []
    left = size
    try:
        for piece in _READERS[kind](data, size):
            left -= len(piece)
            if left < 0:
                break
            pieces.append(piece)
    except (RuntimeError, ValueError, zstandard.ZstdError) as error:
        raise ValueError("a chunk cannot be decompressed") from error
    if left:
        raise ValueError("a chunk does not have the size that it states")
    return pieces[0] if len(pieces) == 1 else b"".join(pieces)


def _plain(data: bytes, size: int) -> Iterator[bytes]:
    yield data


def _zstd(data: bytes, size: int) -> Iterator[bytes]:
    decompressor = zstandard.ZstdDecompressor(max_window_size=max(size, _WINDOW_BYTES))
    with decompressor.stream_reader(data) as reader:
        while piece := reader.read(_piece(size)):
            yield piece


def _lz4(data: bytes, size: int) -> Iterator[bytes]:
    decompressor = lz4.frame.LZ4FrameDecompressor()
    piece = decompressor.decompress(data, max_length=_piece(size))
    while piece:
        yield piece
        if decompressor.eof or decompressor.needs_input:
            return
        piece = decompressor.decompress(b"", max_length=_piece(size))


def _piece(size: int) -> int:
    return max(_PIECE_BYTES, size // _PIECES)


_READERS: dict[str, Callable[[bytes, int], Iterator[bytes]]] = {"": _plain, "zstd": _zstd, "lz4": _lz4}
