import pytest

from gaitopt.errors import InputError
from gaitopt.sweep.table import selected

ROWS = [
    {"speed": 0.7, "status": "certified", "certified": True, "cost": 864.0},
    {"speed": 0.9, "status": "not certified", "certified": False, "cost": 2168.0},
    {"speed": 1.3, "status": "infeasible", "certified": False},
]


@pytest.mark.parametrize(
    ("condition", "speeds"),
    [
        ("speed>0.8", [0.9, 1.3]),
        ("speed>3km/h", [0.9, 1.3]),
        ("speed < '3 km/h'", [0.7]),
        ("speed <= 0.9", [0.7, 0.9]),
        ("cost<1000", [0.7]),
        ("status=certified", [0.7]),
        ("status!='certified'", [0.9, 1.3]),
        ("status=not certified", [0.9]),
        ("certified = false", [0.9, 1.3]),
        ("speed>0.8 and cost>100", [0.9]),
    ],
)
def test_conditions(condition, speeds):
    assert [row["speed"] for row in selected(ROWS, [condition])] == speeds


@pytest.mark.parametrize(
    ("condition", "said"),
    [
        ("__import__('os')", "no condition"),
        ("velocity>1", "no column 'velocity'"),
        ("sped>1", "did you mean 'speed'"),
        ("ertif=1", "did you mean 'certified'"),
        ("nosuch=1", "no column 'nosuch'; 'gaitopt library"),
        ("speed>>1", "no condition"),
        ("cost<abc", "cost holds numbers"),
        ("speed>3kg", "speed holds numbers"),
        ("speed>nan", "no number"),
        ("status=5", "status holds words, as 'certified'"),
        ("certified=yes", "certified holds numbers"),
        ("speed>0.8 and", "'speed>0.8 and' is no condition; .* joined by 'and' only"),
        ("speed>0.8 or cost<5", "joined by 'and' only"),
        ("status=certified or", "joined by 'and' only"),
        ("", "no condition"),
    ],
)
def test_what_is_no_condition_is_refused(condition, said):
    with pytest.raises(InputError, match=said):
        selected(ROWS, [condition])
