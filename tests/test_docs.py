"""What the documents say of files, commands, keys and equations is there."""

import re
import xml.etree.ElementTree as ET

import pytest

from analysis import contact_laws
from analysis.__main__ import COMMANDS
from analysis.docs import design, method, sketch, write
from analysis.files import ROOT
from analysis.formats import markdown
from analysis.formats.run_record import STAGES as RUN_STAGES
from analysis.scenarios import deviations
from analysis.scenarios.scenario import (
    SCENARIO_FILE,
    load_scenario,
    profile_names,
    scenario_names,
    variant_names,
)
from analysis.scenarios.schema import KEYS

MADE = re.compile(r"\..*|results|report|build|\w+\.egg-info")
"""Folders that are not in the repository."""
DOCUMENTS = [path for path in sorted(ROOT.rglob("*.md")) if not any(map(MADE.fullmatch, path.relative_to(ROOT).parts))]
WANTED = write.files()
GUIDES = [path for path in DOCUMENTS if path.name != "PARAMETERS.md"]
EXAMPLES = {
    found[2]: (found[1], block)
    for path in GUIDES
    for block in re.findall(r"```toml\n(.*?)```", path.read_text(encoding="utf-8"), flags=re.DOTALL)
    if (found := re.match(r'\[(scenario|variant)\."?([\w.-]+)"?\]', block))
}
"""What documents show of scenarios and variants that a reader may add: name -> (kind, text)."""


def name(path):
    return str(path.relative_to(ROOT))


def anchors(text):
    """GitHub's anchors of a file's headings."""
    titles = re.findall(r"^#+ (.+)$", text, flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.strip().lower()).replace(" ", "-") for title in titles}


@pytest.mark.parametrize("path", WANTED, ids=name)
def test_what_follows_from_the_code_is_up_to_date(path):
    assert path.read_text(encoding="utf-8") == WANTED[path], "run `make docs` and commit it"


def test_a_document_without_its_marks_is_refused():
    with pytest.raises(ValueError, match="docs/method.md: the lines .* are missing"):
        markdown.replaced("# Method", "stages", write.COMMAND, "text", "docs/method.md")


@pytest.mark.parametrize("path", DOCUMENTS, ids=name)
def test_relative_links_lead_to_files_and_headings_that_exist(path):
    text = re.sub(r"```.*?```", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if re.match(r"[a-z]+:", target):
            continue
        file, _, heading = target.partition("#")
        found = (path.parent / file).resolve() if file else path
        assert found.exists(), target
        if heading:
            assert heading in anchors(found.read_text(encoding="utf-8")), target


@pytest.mark.parametrize("path", DOCUMENTS, ids=name)
def test_no_document_names_a_folder_of_somebodys_machine(path):
    assert not re.findall(r"(?<![\w.<>/])/(?:home|root|tmp|work|mnt|Users)/\S*", path.read_text(encoding="utf-8"))


@pytest.mark.parametrize("path", DOCUMENTS, ids=name)
def test_the_commands_that_documents_name_exist(path):
    text = path.read_text(encoding="utf-8")
    targets = set(re.findall(r"^([a-z-]+(?: [a-z-]+)*):", (ROOT / "Makefile").read_text(), flags=re.MULTILINE))
    targets = {target for line in targets for target in line.split()}
    for target in re.findall(r"(?:`|    |^)make ((?:-j\d )?[a-z][\w.-]*)(?=[ `\n])", text, flags=re.MULTILINE):
        target = target.removeprefix("-j2 ")
        made = re.fullmatch(r"(?:yade|liggghts)-(.+)", target)
        known = target in targets or (made and made[1] in {*scenario_names(), *EXAMPLES})
        assert known, f"make {target}"
    for command in re.findall(r"(?:`|bin/|-m )(?:ballast|analysis) ([a-z]+)", text):
        assert command in COMMANDS, f"ballast {command}"


@pytest.mark.parametrize("path", GUIDES, ids=name)
def test_the_keys_and_variants_that_documents_name_exist(path):
    text = path.read_text(encoding="utf-8")
    sections = {key.partition(".")[0] for key in KEYS}
    for key in re.findall(r"`((?:\w+\.)+\w+)`", text):
        if key.partition(".")[0] in sections and key.rpartition(".")[2] not in ("in", "py", "csv", "json"):
            assert any(f"{known}.".startswith(f"{key}.") for known in KEYS), key
    for variant in re.findall(r"VARIANT=([\w.,-]+)", text):
        assert set(variant.rstrip(".,").split(",")) <= {*variant_names(), *EXAMPLES}, variant


@pytest.mark.parametrize("added", EXAMPLES)
@pytest.mark.parametrize("profile", profile_names())
def test_a_scenario_or_variant_from_the_documents_can_be_added(added, profile, tmp_path):
    kind, block = EXAMPLES[added]
    head, first, tail = SCENARIO_FILE.read_text(encoding="utf-8").partition("\n[variant.")
    file = tmp_path / "scenarios.toml"
    file.write_text(f"{head}\n{block}{first}{tail}", encoding="utf-8")
    known = next(iter(scenario_names()))
    name, variant = (added, "") if kind == "scenario" else (known, added)
    changed = load_scenario(name, profile, file, variant=variant)
    assert changed.hash != load_scenario(known, profile).hash


# ------------------------------------------------------------------ method


def test_the_method_has_the_steps_of_the_decks_in_their_order_and_words():
    told = re.findall(r"^(\d)\. \*\*(.+?)\*\*", method.STAGES.read_text(encoding="utf-8"), flags=re.MULTILINE)
    decks = [
        heading
        for stage in RUN_STAGES
        for heading in re.findall(
            r"^# (\d)\. (.+)$", (ROOT / "liggghts" / f"{stage}.in").read_text(encoding="utf-8"), flags=re.MULTILINE
        )
    ]
    assert [number for number, _ in told] == [number for number, _ in decks]
    for (_, words), (_, heading) in zip(told, decks, strict=True):
        assert heading.lower().startswith(words.lower())


def test_each_equation_of_the_paper_is_in_the_method_and_in_the_laws():
    text = (ROOT / "docs" / "method.md").read_text(encoding="utf-8")
    assert [int(n) for n in re.findall(r"\\tag\{(\d+)\}", text)] == list(method.EQUATIONS)
    assert all(method.equation_functions().values())


def test_equations_are_read_from_the_docstrings_of_the_laws():
    assert method.equations_of(contact_laws.shear_strength) == [4, 12]
    assert method.equations_of(contact_laws.hysteretic_dashpot_coefficient) == [14, 15]
    assert method.equations_of(contact_laws.effective_restitution) == []


def test_the_sketch_shows_the_numbers_of_its_scenario():
    usual, stronger = (
        ET.fromstring(sketch.svg(s))
        for s in (
            load_scenario("linear-mu0.8"),
            load_scenario("linear-mu0.8").with_values({"loading.stress_max": 230e3}),
        )
    )
    words = [
        "\n".join(e.text or "" for e in root.iter("{http://www.w3.org/2000/svg}text")) for root in (usual, stronger)
    ]
    assert "10.4 to 95.7 kN at 20 Hz" in words[0] and "10.4 to 47.8 kN at 20 Hz" in words[1]
    assert usual.get("aria-label")


# ------------------------------------------------------------------ deviations


@pytest.mark.parametrize("deviation", deviations.DEVIATIONS, ids=lambda d: f"{d.code}: {d.law}")
def test_each_deviation_concerns_some_scenarios_and_not_others_unless_it_concerns_all(deviation):
    linear, hysteretic = load_scenario("linear-mu0.8"), load_scenario("nonlinear-md1-en0.6")
    varied = [load_scenario("nonlinear-md1-en0.6", variant=name) for name in ("stock", "limit-rule")]
    concerned = [deviation.applies(s) for s in (linear, hysteretic, *varied, load_scenario("chen2015"))]
    assert any(concerned) and all(concerned) == (deviation.when == "all")


def test_the_deviation_of_the_dashpot_says_the_restitution_of_the_scenario():
    said = deviations.sentences(load_scenario("nonlinear-md1-en0.6"), "yade")
    assert any("restitution 0.7561" in sentence and "e_n = 0.6" in sentence for sentence in said)
    assert not any(
        "estitution" in sentence for sentence in deviations.sentences(load_scenario("nonlinear-en1.0"), "yade")
    )


def test_liggghts_has_the_papers_laws_unless_asked_for_its_own():
    assert not deviations.sentences(load_scenario("nonlinear-md1-en0.6"), "liggghts")
    assert deviations.sentences(load_scenario("nonlinear-en1.0", variant="stock"), "liggghts")


# ------------------------------------------------------------------ design


def test_the_columns_of_plates_are_shown_as_a_range():
    assert design.shortened(("cycle", "lateral_1_m", "lateral_2_m")) == "`cycle`, `lateral_1_m` to `lateral_2_m`"
