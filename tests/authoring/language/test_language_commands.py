"""convert, fmt and schema, as an author calls them."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml
from click.testing import CliRunner, Result
from generated_missions import missions
from hypothesis import given
from test_language_round_trip import SOME

from mission.authoring.language import MissionErrors, digest, layout, load, parse, to_yaml
from mission.authoring.language.schema import schema
from mission.cli import main
from mission.model import Mission
from mission.model.extent import BYTES

MISSIONS = Path(__file__).resolve().parents[3] / "missions"
SHIPPED = sorted(p for p in MISSIONS.iterdir() if p.suffix in (".yaml", ".mission"))
IN_YAML = [path for path in SHIPPED if path.suffix == ".yaml"]


def call(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(a) for a in arguments])


# --- convert ---------------------------------------------------------------------------------


@pytest.mark.parametrize("path", SHIPPED, ids=lambda p: p.name)
@pytest.mark.parametrize("form", ["yaml", "lines"])
def test_convert_keeps_the_digest(path: Path, form: str, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert call("convert", path, "-o", out, "--to", form).exit_code == 0
    assert digest(load(out)) == digest(load(path))


def test_convert_writes_the_other_form_to_standard_output() -> None:
    lines = call("convert", MISSIONS / "harbour-survey.yaml").stdout
    assert lines.startswith("mission harbour-survey vehicle auv\nhome 30.2874595 120.1535765\n")
    yaml_text = call("convert", MISSIONS / "harbour-survey.mission").stdout
    assert yaml_text.startswith("mission: harbour-survey\n")
    assert digest(parse(lines)) == digest(parse(yaml_text))


def test_convert_goes_by_the_suffix_and_sets_parameters(tmp_path: Path) -> None:
    out = tmp_path / "long.mission"
    done = call("convert", MISSIONS / "lawnmower.yaml", "-o", out, "--param", "row_length=200 m")
    assert done.exit_code == 0
    assert "length 200 " in out.read_text("utf-8")


def test_convert_tells_errors_on_standard_error_with_exit_2(tmp_path: Path) -> None:
    broken = tmp_path / "broken.mission"
    broken.write_text("ZAF130\nwait 5\n", "utf-8")
    for arguments in ([broken], [tmp_path / "absent.yaml"], [broken, "--param", "x"]):
        done = call("convert", *arguments)
        assert (done.exit_code, done.stdout) == (2, "")
        assert str(tmp_path) in done.stderr or "NAME=VALUE" in done.stderr
    ok = MISSIONS / "first-dive.yaml"
    assert call("convert", ok, "-o", tmp_path / "no" / "folder.yaml").exit_code == 2


# --- fmt -------------------------------------------------------------------------------------

UNTIDY_LINES = """\
mission u


  # about the first leg
x :   gear 3   until ( depth>5 and elapsed>3 )or depth<1->x timeout   30 #one
repeat 2   g :
y: gear 4 for 3s     # two
   # about z
z: gear 5 depth 3 for 3s # three
+until depth>3
end

"""
TIDY_LINES = """\
mission u

# about the first leg
x: gear 3 until (depth > 5 and elapsed > 3) or depth < 1 -> x timeout 30  #one
repeat 2 g:
  y: gear 4 for 3s  # two
  # about z
  z: gear 5 depth 3 for 3s  # three
    + until depth > 3
end
"""
UNTIDY_YAML = """\
# top
mission:   u


safety: { radius: 100 m ,time: 10 min }   # one
legs:
# about dive
- dive: {depth: 5 m, for:   20 s}  # two
- g:
   repeat: 2
   legs:
   # about a
   -   a:
          depth: 3 m
          gear: 40e-1     # three
          until: [ depth >= 2 -> up ,
             elapsed > 20 ]
   -  'b': {"for": 3}
   on:
   - {when: depth > 8 m, do: up}
- ZAF6
- up: {surface,
    timeout: 40}
# tail
"""
TIDY_YAML = """\
# top
mission: u

safety: {radius: 100 m, time: 10 min}  # one
legs:
  # about dive
  - dive: {depth: 5 m, for: 20 s}  # two
  - g:
      repeat: 2
      legs:
        # about a
        - a:
            depth: 3 m
            gear: 40e-1  # three
            until: [depth >= 2 -> up,
               elapsed > 20]
        - 'b': {"for": 3}
      on:
        - {when: depth > 8 m, do: up}
  - ZAF6
  - up: {surface,
      timeout: 40}
# tail
"""


@pytest.mark.parametrize(
    ("untidy", "tidy"),
    [(UNTIDY_LINES, TIDY_LINES), (UNTIDY_YAML, TIDY_YAML)],
    ids=["lines", "yaml"],
)
def test_fmt_changes_blanks_alone_and_is_done_once(untidy: str, tidy: str, tmp_path: Path) -> None:
    path = tmp_path / "u"
    path.write_text(untidy, "utf-8")
    assert call("fmt", path, "--check").exit_code == 1
    assert path.read_text("utf-8") == untidy
    assert call("fmt", path, "--stdout").stdout == tidy
    assert path.read_text("utf-8") == untidy
    assert call("fmt", path).exit_code == 0
    assert path.read_text("utf-8") == tidy
    assert call("fmt", path, "--check").exit_code == 0
    assert re.sub(r"\s+", "", tidy) == re.sub(r"\s+", "", untidy)
    assert parse(tidy) == parse(untidy)
    assert [p.name for p in tmp_path.iterdir()] == ["u"]


def test_fmt_leaves_a_file_with_errors_alone(tmp_path: Path) -> None:
    broken = tmp_path / "broken.mission"
    broken.write_text("ZAF130\n  wait   5\n", "utf-8")
    done = call("fmt", broken)
    assert done.exit_code == 2
    assert "gear and seconds run together" in done.stderr
    assert broken.read_text("utf-8") == "ZAF130\n  wait   5\n"


@pytest.mark.parametrize("path", SHIPPED, ids=lambda p: p.name)
def test_shipped_missions_are_laid_out(path: Path) -> None:
    text = path.read_text("utf-8")
    assert layout.formatted(text, str(path)) == text


# --- schema ----------------------------------------------------------------------------------


class Yaml12(yaml.SafeLoader):
    """As editors read YAML: 1.2, where on, off, yes and no are plain texts."""


Yaml12.yaml_implicit_resolvers = {
    first: [(tag, how) for tag, how in rows if not (tag.endswith(":bool") and first in "yYnNoO")]
    for first, rows in yaml.SafeLoader.yaml_implicit_resolvers.items()
}


def complaints(text: str) -> list[str]:
    validator: Any = jsonschema.Draft7Validator(schema())
    return [error.message for error in validator.iter_errors(yaml.load(text, Loader=Yaml12))]


def test_the_schema_is_a_schema_and_is_printed_whole() -> None:
    jsonschema.Draft7Validator.check_schema(schema())
    assert json.loads(call("schema").stdout) == schema()


@pytest.mark.parametrize("path", IN_YAML, ids=lambda p: p.name)
def test_shipped_missions_fit_the_schema(path: Path) -> None:
    assert complaints(path.read_text("utf-8")) == []
    assert complaints(to_yaml(load(path))) == []


@pytest.mark.proof
@SOME
@given(missions())
def test_whatever_is_written_as_yaml_fits_the_schema(mission: Mission) -> None:
    assert complaints(to_yaml(mission)) == []


@pytest.mark.parametrize(
    "leg",
    ["{dpeth: 5 m}", "{depth: 5 V}", "{rows: 4, bearing: 90}", "{for: [5]}", "{goto: {north: 5}}", "{}",
     "{side: left}", "{legs: []}", "{repeat: 2}"],
)  # fmt: skip
def test_the_schema_refuses_what_the_language_refuses(leg: str) -> None:
    assert complaints(f"mission: m\nlegs:\n  - a: {leg}\n")


def test_every_word_is_explained_on_hover() -> None:
    def described(node: Any, path: str) -> None:
        assert node.get("description") or node.get("allOf"), path

    made = schema()
    for name in ("leg", "group"):
        for word, node in made["definitions"][name]["properties"].items():
            described(node, f"{name}.{word}")
    for word, node in made["properties"].items():
        described(node, word)


@pytest.mark.parametrize("command", ["check", "convert", "fmt", "simulate"])
def test_a_file_that_never_ends_or_is_no_text_is_refused_alike(
    command: str, tmp_path: Path
) -> None:
    long = tmp_path / "long.yaml"
    long.write_text("mission: m\n" + "# a comment\n" * (BYTES.most // 12))
    binary = tmp_path / "binary.mission"
    binary.write_bytes(bytes(range(256)))
    for path, why in ((long, "more than 4,194,304 bytes in a file"), (binary, "it is not UTF-8")):
        ran = call(command, path)
        assert ran.exit_code == 2
        assert f"{path}: cannot be read: " in ran.stderr
        assert why in ran.stderr
        assert "codec" not in ran.stderr


@pytest.mark.parametrize(
    ("arguments", "stage"),
    [(["absent.yaml"], "text"), (["first-dive", "--vehicle", "nessie"], "vehicle")],
)
def test_a_program_is_told_too_why_nothing_could_be_read(arguments: list[str], stage: str) -> None:
    ran = call("check", *arguments, "--json")
    assert ran.exit_code == 2
    (refusal,) = json.loads(ran.stdout)["refusals"]
    told = (refusal["stage"], refusal["code"], refusal["line"])
    assert told == (stage, "unreadable", 0)
    assert refusal["hint"]


def test_a_place_alone_in_a_value_is_told_as_a_place() -> None:
    with pytest.raises(MissionErrors) as caught:
        parse("mission: m\nlegs: [{g: {goto: base, gear: 8, timeout: 60}}]\n")
    (problem,) = caught.value.diagnostics
    assert (problem.code, problem.offending) == ("place", "base")
    assert "north 10 east 20" in problem.hint


def test_an_empty_file_is_shown_without_an_empty_line() -> None:
    with pytest.raises(MissionErrors) as caught:
        parse("", "empty.yaml")
    assert "^" not in str(caught.value)


def test_converted_yaml_reads_as_the_documentation_writes_it() -> None:
    text = call("convert", MISSIONS / "harbour-survey.mission", "--to", "yaml").stdout
    assert "home: {latitude: 30.2874595, longitude: 120.1535765}\n" in text
    assert "safety: {radius: 1400 m, time: 45 min, depth: 30 m, voltage: 10 V}\n" in text


def test_a_word_behind_a_number_where_a_unit_may_stand_is_told_as_one() -> None:
    with pytest.raises(MissionErrors) as caught:
        parse("wait 3 fortnights\nwait 30 untill depth > 3\n")
    assert [(p.code, p.hint[:16]) for p in caught.value.diagnostics] == [
        ("unknown-unit", "units: m, km, cm"),
        ("unknown-word", "did you mean unt"),
    ]
