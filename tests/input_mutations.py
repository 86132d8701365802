"""Inputs changed at random, of every kind that gaitopt takes: MJCF, TOML, JSON, gait files, words.

URDFs have a file of their own, `urdf_mutations`. Everything follows from the generator given.
"""

from __future__ import annotations

import copy
import hashlib
import io
import json
import re
import sys
import zipfile
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import tomli_w
from urdf_mutations import FORMS, damage, double, drop, misspell, move, pick

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

Rng = np.random.Generator

_MJCF_NAMES = ("world", "", "trunk", "a/b", "x" * 300, "left_knee", "base", "\u202eevil", "0")
_MJCF_ADDED = (
    ("joint", "limited", ("true", "false", "auto", "yes")),
    ("joint", "ref", ("0.3", "30", "nan")),
    ("joint", "armature", ("0.01", "-1", "1e9")),
    ("joint", "damping", ("1", "1 2 3", "1 2 3 4", "-1")),
    ("joint", "frictionloss", ("0.5", "-0.5")),
    ("joint", "stiffness", ("10", "10 5", "-1")),
    ("joint", "springref", ("0.1", "10")),
    ("joint", "springdamper", ("0.1 0.1", "0 0")),
    ("joint", "type", ("slide", "ball", "free", "hinge", "screw")),
    ("joint", "pos", ("0 0 0.1", "0.1")),
    ("joint", "actuatorfrcrange", ("-10 20", "5 -5", "-30 -20")),
    ("joint", "actuatorgravcomp", ("true",)),
    ("body", "gravcomp", ("1", "0.5", "-1")),
    ("body", "mocap", ("true",)),
    ("body", "childclass", ("none", "main")),
    ("body", "euler", ("10 20 30", "1 2")),
    ("body", "quat", ("0 0 0 0", "1 1 0 0")),
    ("body", "zaxis", ("0 0 0", "1 0 0")),
    ("body", "fromto", ("0 0 0 1 1 1",)),
    ("geom", "mass", ("0", "1", "-1", "1e300")),
    ("geom", "density", ("0", "1", "-1")),
    ("geom", "fromto", ("0 0 0 0 0 0.2", "0 0 0 0 0 0")),
    ("geom", "shellinertia", ("true",)),
    ("geom", "fluidshape", ("ellipsoid",)),
    ("geom", "type", ("plane", "hfield", "sdf", "mesh", "ellipsoid", "cone")),
    ("geom", "contype", ("0", "-1", "x")),
    ("inertial", "fullinertia", ("1 1 1 0 0 0", "1 1 5 0 0 0")),
    ("compiler", "angle", ("degree", "radian", "turn")),
    ("compiler", "coordinate", ("global", "local")),
    ("compiler", "inertiafromgeom", ("true", "false", "auto")),
    ("compiler", "inertiagrouprange", ("1 3", "3 1", "0 9")),
    ("compiler", "settotalmass", ("40", "-1", "1e-3", "1e30")),
    ("compiler", "boundmass", ("1", "1e9")),
    ("compiler", "balanceinertia", ("true",)),
    ("compiler", "fusestatic", ("true",)),
    ("compiler", "discardvisual", ("true",)),
    ("compiler", "autolimits", ("false",)),
    ("compiler", "eulerseq", ("XYZ", "xyz", "abc")),
    ("option", "gravity", ("0 0 0", "0 0 -1.6", "9.81 0 0", "0 0 9.81", "nan 0 0")),
    ("option", "density", ("1000",)),
    ("option", "wind", ("1 0 0",)),
    ("option", "timestep", ("0", "-1", "1e-9")),
    ("motor", "gear", ("0", "-5", "1 2 3 4 5 6", "1e200")),
    ("motor", "ctrlrange", ("-1 1", "1 -1")),
    ("motor", "forcerange", ("-1 1", "0 0", "5 9")),
    ("motor", "joint", ("no_such", "")),
    ("motor", "dyntype", ("integrator", "filter", "muscle")),
    ("size", "memory", ("1G", "900P", "-1", "16")),
    ("size", "nconmax", ("1000000000",)),
)
_MJCF_PARTS = (
    "<include file='robot.xml'/>",
    "<include file='nowhere.xml'/>",
    "<replicate count='3' offset='0 1 0'><body><geom size='.1'/></body></replicate>",
    "<replicate count='100000000'><body><geom size='.1'/></body></replicate>",
    "<composite type='cable' count='99999 1 1'/>",
    "<frame euler='0 30 0'/>",
    "<freejoint/>",
    "<body name='more'><freejoint/><geom size='.1'/></body>",
    "<body mocap='true'><geom size='.1'/></body>",
    "<geom size='0.05' mass='0.3'/>",
    "<geom type='mesh' mesh='absent'/>",
    "<site name='spot'/>",
    "<joint type='ball'/>",
    "<flexcomp name='cloth' type='grid' count='999 999 1' spacing='.1 .1 .1'/>",
    "<attach model='other' body='trunk' prefix='p'/>",
    "<plugin plugin='mujoco.elasticity.cable'/>",
    "<inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/>",
    "<option gravity='0 0 -3.7'/>",
    "<compiler angle='radian'/>",
    "<default><joint damping='2'/></default>",
    "<option><flag gravity='disable'/></option>",
    "<asset><mesh name='void' vertex='0 0 0 1 0 0'/></asset>",
    "<equality><weld body1='world' body2='base'/></equality>",
    "<!-- -->",
    "<extension/>",
    "<size njmax='5'/>",
)


def mutate_mjcf(text: str, rng: Rng, times: int = 1) -> str:
    """An MJCF text changed in one place or several: numbers, elements, names, settings."""
    for _ in range(times):
        if rng.random() < 0.05:
            text = damage(text, rng)
            continue
        try:
            root = ET.fromstring(text)
        except ET.ParseError:
            return text
        if len(root):
            edits = (
                _mjcf_number, _mjcf_number, _mjcf_number, _mjcf_scale, _mjcf_set, _mjcf_set,
                _mjcf_part, _mjcf_rename, double, drop, misspell, move,
            )  # fmt: skip
            edits[rng.integers(len(edits))](root, rng)
        text = ET.tostring(root, encoding="unicode")
    return text


def _attribute(root, rng):
    """An attribute of numbers, if one of some tried is such."""
    found = [(e, k) for e in root.iter() for k in e.attrib]
    for _ in range(20):
        element, key = pick(found, rng)
        if any(c.isdigit() for c in element.get(key)) and key not in ("name", "joint", "class"):
            return element, key
    return element, key


def _mjcf_number(root, rng):
    element, key = _attribute(root, rng)
    words = element.get(key).split() or ["0"]
    place = int(rng.integers(len(words)))
    words[place] = str(pick(FORMS, rng)).format(words[place])
    element.set(key, " ".join(words))


def _mjcf_scale(root, rng):
    element, key = _attribute(root, rng)
    words = element.get(key).split() or ["0"]
    place = int(rng.integers(len(words)))
    try:
        factor = float(rng.choice([-1.0, 0.0, 0.3, 1.1, 1e3, 1e12]))
        words[place] = repr(float(words[place]) * factor)
    except ValueError:
        return
    element.set(key, " ".join(words))


def _mjcf_set(root, rng):
    tag, key, values = pick(_MJCF_ADDED, rng)
    found = list(root.iter(tag))
    element = pick(found, rng) if found else ET.SubElement(root, tag)
    element.set(key, pick(values, rng))


def _mjcf_part(root, rng):
    parents = [e for e in root.iter() if e.tag in ("mujoco", "worldbody", "body")]
    parent = pick(parents, rng) if parents else root
    part = ET.fromstring(f"<x>{pick(_MJCF_PARTS, rng)}</x>")
    for child in part:
        parent.insert(int(rng.integers(len(parent) + 1)), child)


def _mjcf_rename(root, rng):
    named = [
        (e, k) for e in root.iter() for k in ("name", "joint", "class", "mesh") if k in e.attrib
    ]
    if named:
        element, key = pick(named, rng)
        element.set(key, str(pick([*_MJCF_NAMES, *(e.get(k) for e, k in named)], rng)))


_VALUES: tuple[Any, ...] = (
    0, 1, -1, 2, 3, 0.0, -0.0, 0.1, -0.4, 1e-9, 1e9, 1e308, -1e308, 1e-320, 10**30, -(10**25),
    2**63, float("nan"), float("inf"), -float("inf"), True, False, "", "x", "1.0", "none",
    "None", "nan", "*", "[", "../..", "/", "\x1b[31mred", "\u0000", "\u202e", "y" * 5000, [],
    [1.0], [[]], [1, "a"],
    ["x"], [[0.0] * 6] * 2, {}, {"x": 1}, {"": {}}, [{}], [None], None, [float("nan")] * 4,
)  # fmt: skip


def mutate_record(record: Any, rng: Rng, names: tuple[str, ...] = ()) -> Any:
    """Plain data (tables, lists, values) changed in one place.

    Args:
        record: the data, left as they are.
        rng: decides.
        names: that may be added to tables.
    """
    data = {"": copy.deepcopy(record)}
    places = list(_record_places(data))[1:] or [(data, "")]
    holder, key = pick(places, rng)
    value, what = holder[key], rng.integers(8)
    if rng.random() < 0.35 and isinstance(value, (int, float)) and not isinstance(value, bool):
        changed = value * float(rng.choice([-1.0, 0.0, 0.5, 0.9, 0.99, 1.01, 1.1, 2.0, 10.0, 1e3]))
        holder[key] = int(changed) if isinstance(value, int) and abs(value) < 1e9 else changed
    elif what == 0 and isinstance(holder, (dict, list)) and holder is not data:
        del holder[key]
    elif what == 1 and isinstance(holder, dict) and holder is not data:
        holder[_typo(str(key), rng)] = holder.pop(key)
    elif what == 2 and isinstance(holder, dict) and names:
        holder[pick(names, rng)] = copy.deepcopy(pick(_VALUES, rng))
    elif what == 3 and isinstance(value, (int, float)):
        holder[key] = -value
    elif what == 4 and isinstance(holder, list):
        holder.insert(int(rng.integers(len(holder) + 1)), copy.deepcopy(holder[key]))
    elif what == 5:  # one that stands elsewhere
        other, place = pick(places, rng)
        holder[key] = copy.deepcopy(other[place])
    else:
        holder[key] = copy.deepcopy(pick(_VALUES, rng))
    return data[""]


def _record_places(value):
    entries = value.items() if isinstance(value, dict) else enumerate(value)
    for key, inner in list(entries):
        yield value, key
        if isinstance(inner, (dict, list)):
            yield from _record_places(inner)


def _typo(word: str, rng: Rng) -> str:
    if not word:
        return "x"
    place = int(rng.integers(len(word)))
    return pick([word[:place] + word[place + 1 :], word.upper(), word + "s", "", "a b"], rng)


def mutate_toml(text: str, rng: Rng, times: int = 1, names: tuple[str, ...] = ()) -> bytes:
    """A TOML text changed in one place or several; sometimes its bytes, not its meaning."""
    for _ in range(times):
        if rng.random() < 0.15:
            text = _toml_text(text, rng)
            continue
        try:
            table = tomllib.loads(text)
            changed = mutate_record(table, rng, names)
            text = tomli_w.dumps(_without_none(changed if isinstance(changed, dict) else {}))
        except (ValueError, TypeError, AttributeError, RecursionError):
            continue  # as of what is nested too deep by the mutation before
    data = text.encode("utf-8", "surrogatepass")
    return mutate_bytes(data, rng) if rng.random() < 0.05 else data


def _without_none(value):
    if isinstance(value, dict):
        return {str(k): _without_none(v) for k, v in value.items() if v is not None}
    if isinstance(value, list):
        return [_without_none(v) for v in value if v is not None]
    return value


def _toml_text(text: str, rng: Rng) -> str:
    lines = text.split("\n")
    place = int(rng.integers(len(lines)))
    what = rng.integers(6)
    if what == 0:
        lines.insert(place, lines[place])
    elif what == 1:
        del lines[place]
    elif what == 2:
        lines[place] = lines[place].replace("=", ":", 1)
    elif what == 3:
        lines.insert(place, pick(["[[task]]", "[x.y", "a = ", "= 1", "a.b.c = 1", "[" * 2000], rng))
    elif what == 4:
        lines[place] = lines[place].replace("]", "").replace('"', "'", 1)
    else:
        return damage(text, rng) if text else text
    return "\n".join(lines)


def mutate_bytes(data: bytes, rng: Rng) -> bytes:
    """Bytes damaged: cut, flipped, doubled, filled, or in another encoding."""
    if not data:
        return pick([b"\x00", b"\xff\xfe", b" "], rng)
    place, what = int(rng.integers(len(data))), rng.integers(9)
    if what == 0:
        return data[:place]
    if what == 1:
        return data[:place] + bytes([int(rng.integers(256))]) + data[place + 1 :]
    if what == 2:
        return data[:place] + data[place + int(rng.integers(1, 200)) :]
    if what == 3:
        return data + data[place:]
    if what == 4:
        return data[:place] + b"\x00" * 64 + data[place:]
    if what == 5:
        return b"\xef\xbb\xbf" + data
    if what == 6:
        return data.decode("latin-1").encode("utf-16")
    if what == 7:
        return data[:place] + rng.bytes(int(rng.integers(1, 99))) + data[place:]
    return pick([b"", b"\x00", b"\n", data.replace(b"\n", b"\r\n"), data[::-1]], rng)


def mutate_json_lines(data: bytes, rng: Rng, names: tuple[str, ...] = ()) -> bytes:
    """A file of one JSON value a line, or of one in all, changed in one place."""
    whole = data.startswith(b"{\n")
    lines = [data] if whole else data.splitlines()
    place = int(rng.integers(len(lines)))
    what = rng.random()
    if what < 0.1 and not whole:
        lines.insert(int(rng.integers(len(lines))), lines[place])
    elif what < 0.2 and not whole:
        del lines[place]
    elif what < 0.3:
        lines[place] = pick([b"[]", b"null", b"1e999", b'"x"', b"{}", b"[" * 100_000], rng)
    else:
        changed = mutate_record(json.loads(lines[place]), rng, names)
        lines[place] = json.dumps(changed).encode()
    return b"\n".join(lines) + b"\n"


def mutate_npz(data: bytes, rng: Rng) -> bytes:
    """A gait file: an array of another value, size or kind, its record, or the archive itself."""
    if rng.random() < 0.15:
        return mutate_bytes(data, rng)
    with np.load(io.BytesIO(data)) as content:
        members = {name: content[name] for name in content.files}
    name = pick(["meta", "meta", "meta", *members], rng)
    extra: list[tuple[str, bytes]] = []
    if name == "meta" and rng.random() < 0.85:
        meta = mutate_record(json.loads(str(members["meta"])), rng)
        members["meta"] = np.array(json.dumps(meta))
    elif members[name].dtype.kind in "US" and rng.random() < 0.7:
        members[name] = _mutate_text_array(name, members[name], rng)
    else:
        changed = _mutate_array(members.pop(name), rng)
        if isinstance(changed, bytes):
            extra.append((name, changed))
        elif changed is not None:
            members[name] = changed
    if rng.random() < 0.8:  # else every change is told by its digest alone
        members["digest"] = np.array(json.dumps(_digests(members)))
    return _npz(members, extra)


def _digests(members) -> dict[str, str]:
    with zipfile.ZipFile(io.BytesIO(_npz(members, []))) as archive:
        parts = {name: archive.read(name) for name in archive.namelist()}
    return {n.removesuffix(".npy"): hashlib.sha256(data).hexdigest() for n, data in parts.items()}


def _mutate_text_array(name, array, rng):
    from urdf_mutations import mutate_urdf

    if name == "urdf":
        return np.array(mutate_urdf(str(array), rng, int(rng.integers(1, 3))))
    if array.ndim == 0:
        return np.array(pick(["", "x", "left_sole", "base", "\u0000", "z" * 9999], rng))
    names = array.astype(object)
    names[int(rng.integers(len(names)))] = pick(["", "x", names[0], "left_knee"], rng)
    return names.astype(str)


def _mutate_array(array, rng) -> np.ndarray | bytes | None:
    what = rng.integers(13)
    if array.dtype.kind == "f" and array.size and what < 5:
        changed, place = array.copy(), int(rng.integers(array.size))
        factor = float(rng.choice([0.0, -1.0, 1.001, 1e6, 1e300, np.nan, np.inf]))
        with np.errstate(all="ignore"):
            changed.flat[place] *= factor
        return changed
    if what == 5:
        return None
    if what == 6:
        return array[:-1] if array.ndim else np.array([array, array])
    if what == 7:
        return np.char.encode(array, "utf-8") if array.dtype.kind == "U" else array.astype(str)
    if what == 8:
        return np.zeros((0, *array.shape[1:]))
    if what == 9:
        return array.astype(complex) if array.dtype.kind == "f" else np.array([1.0])
    if what == 10:
        return np.array([np.datetime64("2020-01-01")] * 3)
    if what == 11:  # a header that promises what is not there
        return b"\x93NUMPY\x01\x00\x76\x00" + (
            b"{'descr': '<f8', 'fortran_order': False, 'shape': (99999999999,), }".ljust(117)
            + b"\n"
        )
    if what == 12:
        buffer = io.BytesIO()
        np.save(buffer, np.array([{}, 1], dtype=object), allow_pickle=True)
        return buffer.getvalue()
    return np.array(array.T, order="F")


def _npz(members: dict[str, np.ndarray], extra: list[tuple[str, bytes]]) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, array in members.items():
            with archive.open(f"{name}.npy", "w") as member:
                np.lib.format.write_array(member, np.asanyarray(array), allow_pickle=False)
        for name, data in extra:
            archive.writestr(f"{name}.npy", data)
    return stream.getvalue()


_FIGURE = re.compile(r"-?\d+(?:\.\d+)?")
_WORDS = (
    "", "0", "-1", "1", "1e9", "nan", "inf", "-inf", "1_0", "٤", "1e400", "99999999999999999999",
    "x", "-", "--", "=", "a=b", "=1", "a=", "speed=", "speed=x", "*=1", "*=nan", "[=1", "1:2",
    "2:1:0.1",
    "0:1:0", "0:1e9:1e-9", "1:2:nan", "1,2,", ",", "0.1,0.1,0.1", "0.1,-0.1,0.05,-0.05", "/", ".",
    "/dev/null", "/dev/full", "/proc/self/mem", "no_such.urdf", "no_such.toml", "\x1b[31m",
    "\u202e", "a\nb", "y" * 3000, "friction", "speed>1", "speed>>1", "cost=nan", "+x", "-y",
    "half_sitting",
    "true", "sqp", "ipopt", "@file", "~", "~nobody/x", "file:///etc", "menagerie:x", "g2",
    "humanoid", "pelvis_roll", "duration", "\udcff",
)  # fmt: skip


def mutate_words(words: list[str], rng: Rng, options: tuple[str, ...]) -> list[str]:
    """The words of a command line, one or two of them changed, added or lost."""
    words = list(words)
    if rng.random() < 0.4:
        return _other_number(words, rng)
    for _ in range(int(rng.integers(1, 3))):
        place, what = int(rng.integers(len(words) + 1)), rng.integers(7)
        if what == 0 and len(words) > 1:
            del words[min(place, len(words) - 1)]
        elif what == 1 and words:
            words[min(place, len(words) - 1)] = pick(_WORDS, rng)
        elif what == 2 and words:
            place = min(place, len(words) - 1)
            words[place] = _typo(words[place], rng)
        elif what == 3:
            words.insert(place, pick(options, rng))
        elif what == 4 and words:
            words.insert(place, words[min(place, len(words) - 1)])
        else:
            words[place:place] = [pick(options, rng), pick(_WORDS, rng)]
    return words


def _other_number(words: list[str], rng: Rng) -> list[str]:
    """Other numbers of the same form: what is still understood, and goes on into the work."""
    found = [(i, m) for i, word in enumerate(words) for m in _FIGURE.finditer(word)]
    if found:
        place, match = pick(found, rng)
        value = float(match[0]) * float(rng.choice([-1.0, 0.0, 0.5, 0.9, 1.1, 2.0, 10.0, 1e3, 1e9]))
        text = f"{value:g}" if "." in match[0] else f"{value:.0f}"
        words[place] = words[place][: match.start()] + text + words[place][match.end() :]
    return words
