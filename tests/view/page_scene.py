"""The scene that a page carries, unpacked as its own script does."""

import base64
import gzip
import json
import re

import numpy as np

from gaitopt.view.viewer import umsgpack


def unpacked(text: str) -> bytes:
    return gzip.decompress(base64.b64decode(text))


def scene_of(page: str) -> list[dict]:
    """The drawing commands of a page."""
    return commands_of(unpacked(re.search(r'PACKED_SCENE = "([^"]*)";', page)[1]))


def data_of(page: str) -> dict:
    """What the script of a page knows."""
    return json.loads(re.search(r"let data = (\{.*?\});\n", page, re.DOTALL)[1])


def numbers(packed: str) -> np.ndarray:
    return np.frombuffer(base64.b64decode(packed), "<f4")


def tracks_of(page: str, motion: dict) -> dict[str, dict[str, np.ndarray]]:
    """The tracks of each animated node: path to values (N, 3 or 4) by property."""
    (clips,) = [c["animations"] for c in scene_of(page) if c["type"] == "set_animation"]
    assert len(clips) == len(motion["tracks"])
    assert {clip["clip"]["fps"] for clip in clips} == {1}
    count = len(numbers(motion["times"]))
    return {
        clip["path"]: {
            track["name"]: numbers(values).reshape(count, -1)
            for track, values in zip(clip["clip"]["tracks"], own, strict=True)
        }
        for clip, own in zip(clips, motion["tracks"], strict=True)
    }


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
