"""The format of a file that is not the text it should be, from the bytes with which it begins."""

from __future__ import annotations

import codecs
import re

_SIGNATURES = (
    (rb"\x89MCAP0\r\n", "an MCAP log"),
    (rb"#ROSBAG V", "a ROS 1 bag"),
    (rb"SQLite format 3\0", "an SQLite database, such as a ROS 2 bag (.db3)"),
    (rb"\x89PNG\r\n\x1a\n", "a PNG image"),
    (rb"\xff\xd8\xff", "a JPEG image"),
    (rb"GIF8[79]a", "a GIF image"),
    (rb"BM.{4}\0\0\0\0", "a BMP image"),
    (rb"(II\*\0|MM\0\*)", "a TIFF image"),
    (rb"RIFF.{4}", "a RIFF file (WebP, WAV or AVI)"),
    (rb".{4}ftyp", "an MP4 video"),
    (rb"PK(\x03\x04|\x05\x06|\x07\x08)", "a zip archive, such as 3MF, NPZ, XLSX or USDZ"),
    (rb"\x1f\x8b", "packed with gzip"),
    (rb"BZh[1-9]", "packed with bzip2"),
    (rb"\xfd7zXZ\0", "packed with xz"),
    (rb"\x28\xb5\x2f\xfd", "packed with zstd"),
    (rb"\x04\x22\x4d\x18", "packed with lz4"),
    (rb"7z\xbc\xaf\x27\x1c", "a 7z archive"),
    (rb"Rar!\x1a\x07", "a RAR archive"),
    (rb".{257}ustar", "a tar archive"),
    (rb"glTF", "a binary glTF model (.glb)"),
    (rb"ply\s", "a binary PLY mesh"),
    (rb"Kaydara FBX Binary", "an FBX model"),
    (rb"BLENDER", "a Blender file"),
    (rb"PXR-USDC", "a USD model"),
    (rb"DRACO", "a Draco mesh"),
    (rb"\x93NUMPY", "a NumPy array (.npy)"),
    (rb"\x89HDF\r\n\x1a\n", "an HDF5 file"),
    (rb"PAR1", "a Parquet table"),
    (rb"MATLAB 5\.0", "a MATLAB file"),
    (rb"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "an old document of Microsoft Office"),
    (rb"%PDF-", "a PDF document"),
    (rb"\x7fELF", "a program (ELF)"),
    (rb"MZ.*\0", "a program for Windows"),
    (rb"(\xff\xfe\0\0|\0\0\xfe\xff)", "UTF-32 text"),
    (rb"(\xff\xfe|\xfe\xff|([\t\n\r -~]\0){4}|(\0[\t\n\r -~]){4})", "UTF-16 text"),
)
"""How a file of each format begins, and what messages call it."""

_BINARY_PLY = re.compile(rb"ply\s(.*[\r\n])?format\s+binary", re.DOTALL)
_KNOWN = [(re.compile(begin, re.DOTALL), name) for begin, name in _SIGNATURES]

_HEAD = 4096
"""Bytes in which a binary file shows that it is none of text."""

_STL_HEADER, _STL_TRIANGLE = 84, 50


def named_format(data: bytes) -> str:
    """Return what a file is that begins like a known format and is no UTF-8 text, as in `a PNG image`; else nothing."""
    head = data[:_HEAD]
    if _is_text(head):  # that of a binary PLY may be
        return "a binary PLY mesh" if _BINARY_PLY.match(head) else ""
    if _is_stl(data):  # whose header is free
        return "a binary STL mesh"
    return next((name for begin, name in _KNOWN if begin.match(data)), "")


def _is_text(head: bytes) -> bool:
    """Tell whether the head of a file is UTF-8 without NULs; a character cut off at its end is none amiss."""
    try:
        codecs.getincrementaldecoder("utf-8")().decode(head)
    except UnicodeDecodeError:
        return False
    return b"\0" not in head


def _is_stl(data: bytes) -> bool:
    """Tell whether the file is exactly as long as a binary STL of as many triangles as its header says."""
    count = int.from_bytes(data[_STL_HEADER - 4 : _STL_HEADER], "little")
    return count > 0 and len(data) == _STL_HEADER + _STL_TRIANGLE * count
