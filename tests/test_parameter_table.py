"""PARAMETERS.md says what scenarios.toml says."""

import pytest

from analysis.scenarios import parameter_table
from analysis.scenarios.scenario import base_parameters, load_scenario, scenario_names


def test_the_committed_table_is_up_to_date():
    committed = parameter_table.PARAMETER_FILE.read_text()
    assert committed == parameter_table.render(), "run `make docs` and commit PARAMETERS.md"


def test_the_table_holds_every_parameter_once_with_its_source():
    base = parameter_table.render().split("## Scenarios")[0]
    for key, p in base_parameters().items():
        row = [
            line
            for line in base.split(f"### {key.rpartition('.')[0]}\n")[1].split("###")[0].splitlines()
            if line.startswith(f"| `{key.rpartition('.')[2]}` |")
        ]
        assert len(row) == 1 and p.status in row[0] and p.source.replace("|", "\\|") in row[0]


def test_the_table_holds_every_difference_of_every_scenario():
    rows = parameter_table.render().split("## Scenarios")[1].split("## Profiles")[0].splitlines()
    base = base_parameters()
    for name in scenario_names():
        names = {name, f"{name.split('-')[0]}-*"}
        for key, p in load_scenario(name).parameters.items():
            named = [r for r in rows if r.startswith(f"| `{key}` |") and names & set(r.split(" | ")[3].split(", "))]
            assert bool(named) == (p.value != base[key].value), (name, key)


@pytest.mark.parametrize(
    "value, text",
    [
        (1e8, "1e8"),
        (2.9e-6, "2.9e-6"),
        (0.0115625, "0.0115625"),
        (0.0, "0"),
        (1000, "1000"),
        (50e3, "50000"),
        (35e6, "3.5e7"),
        ("", "(empty)"),
        ([1e-3, 1.0], "0.001, 1"),
    ],
)
def test_values_are_written_as_short_as_they_are_exact(value, text):
    assert parameter_table._value(value) == text
    if isinstance(value, float):
        assert float(text) == value
