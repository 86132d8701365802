from xml.etree import ElementTree

import pytest

from gaitopt.view.drawable import mergeable

PART = '<triangles count="1">{}</triangles>'
NORMAL = '<input semantic="VERTEX"/><input semantic="NORMAL"/>'
TEXTURE = NORMAL + '<input semantic="TEXCOORD"/>'


@pytest.mark.parametrize(
    ("parts", "expected"),
    [((NORMAL, NORMAL), True), ((NORMAL, TEXTURE), False), ((), False), ((TEXTURE,), True)],
)
def test_meshes_of_one_kind_can_be_merged(parts, expected):
    body = "".join(map(PART.format, parts))
    text = f'<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema">{body}</COLLADA>'
    assert mergeable(ElementTree.fromstring(text)) is expected
