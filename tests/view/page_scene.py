"""The scene that a page carries, unpacked as its own script does."""

import base64
import gzip
import re

from gaitopt.view.viewer import umsgpack


def unpacked(text: str) -> bytes:
    return gzip.decompress(base64.b64decode(text))


def scene_of(page: str) -> list[dict]:
    """The drawing commands of a page."""
    return commands_of(unpacked(re.search(r'PACKED_SCENE = "([^"]*)";', page)[1]))


def places(page: str) -> set[str]:
    """The ids of the elements of a page."""
    return set(re.findall(r'\bid="(\w+)"', page))


def commands_of(data: bytes) -> list[dict]:
    found = []
    while data:
        end = 4 + int.from_bytes(data[:4], "little")
        found.append(umsgpack.unpackb(data[4:end]))
        data = data[end:]
    return found
