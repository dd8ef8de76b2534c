"""The command line as one tool: commands, exit codes, JSON, help with examples, no traceback for mistakes."""

import json
import re
import shutil

import numpy as np
import pytest
import typer
from commanding import typed
from rich.text import Text
from small_scene import HARD, SQUARE_CELLS
from solving import Numbers, solve_all
from typer.testing import CliRunner

from validation.cli import commands as cli
from validation.cli import scenes
from validation.cli.options import key_names, scene_names
from validation.comparison.accuracy import reach
from validation.errors import RunFailed
from validation.execution.bench import Bench
from validation.execution.results import read_results
from validation.execution.store import Store
from validation.report.estimates import total_error
from validation.scenes.scene import load_scene
from validation.scenes.topography.measured import read_topography
from validation.studies import GROUPS, studies

COMMANDS = ("run", "study", "compare", "validate", "reproduce", "report", "explain", "surface", "scenes")


@pytest.fixture
def tool(monkeypatch, capsys, tmp_path):
    """Run the command in this process; return exit code, stdout and stderr."""

    def call(line, *words):
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr("sys.argv", ["fem-contact", *typed(line, *words)])
        with pytest.raises(SystemExit) as exit_:
            cli.main()
        printed = capsys.readouterr()
        return exit_.value.code or 0, printed.out, printed.err

    return call


@pytest.fixture
def done(tool):
    """Run a command that ends well; what it prints."""

    def call(*words):
        code, out, err = tool(*words)
        assert code == 0, err
        return out

    return call


@pytest.fixture
def mistake(tool):
    """Run a command that cannot be run as it is; what stderr says."""

    def call(*words):
        code, _, said = tool(*words)
        assert code == 2
        assert "Traceback" not in said
        return said

    return call


def every_command():
    groups = [typer.main.get_command(cli.app)]
    while groups:
        command = groups.pop()
        groups.extend(getattr(command, "commands", {}).values())
        yield command


def test_a_flag_is_off_unless_there_is_another_to_turn_it_off():
    flags = [one for command in every_command() for one in command.params if getattr(one, "is_flag", False)]
    assert len(flags) > 30
    for flag in flags:
        assert flag.default in ((True, None) if flag.secondary_opts else (False, None)), flag.name


def test_help_names_every_command_with_examples_and_the_exit_codes(done):
    out = done("--help")
    places = [out.index(f"─ {panel} ─") for panel in ("Run", "Ask, without solving", "Check", "Keep house")]
    assert places == sorted(places)
    for command in COMMANDS:
        assert command in out
    assert "Exit codes" in out
    assert "--install-completion" in out
    assert "Examples:" in done("run", "--help")
    for command in every_command():
        if not hasattr(command, "commands"):
            heading, *lines = command.epilog.split("\n\n")
            assert heading == "Examples:", command.name
            assert {line.partition(" ")[0] for line in lines} == {"fem-contact"}, command.name


def test_no_word_of_a_help_text_is_taken_for_markup():
    """Square brackets are eaten by the printer of the help, and what they said with them."""
    texts = []
    for command in every_command():
        texts += [command.help, command.epilog, *(getattr(option, "help", None) for option in command.params)]
    assert len(texts) > 60
    assert [text for text in texts if text and Text.from_markup(text).plain != text] == []


@pytest.mark.parametrize("command", ["run", "explain"])
def test_an_effect_that_does_not_fit_is_named_with_its_file(mistake, write_scene, command):
    path = write_scene(HARD.replace("60 kPa", "1 Pa"))
    words = "[[effects]] 1 hardness = 1 Pa: must not be below the nominal pressure"
    assert f"{path}: {words}" in mistake(command, path)


def test_a_report_of_nothing_names_the_results_that_are_there(mistake, tmp_path):
    for place in ("here/result.json", "there/result.json", "empty/other.json"):
        (tmp_path / "results" / place).parent.mkdir(parents=True)
        (tmp_path / "results" / place).write_text("{}")
    err = mistake("report results/area")
    assert err.rstrip().endswith("run a scene or study first; results are in results/here, results/there")


def test_a_surface_on_the_smallest_grid_is_written_with_a_word_of_warning(tool, write_scene):
    code, _, err = tool("surface generate", write_scene(), "rough.nc")
    assert code == 0, err
    assert "note: 9 x 5 is the smallest grid that resolves this surface" in err
    assert tool("surface generate quickstart fine.nc --grid 40")[2] == ""


def test_shell_completion_can_be_shown_and_completes_scenes(tmp_path, monkeypatch):
    # The shell is named, for there may be none above the tests to be found out.
    monkeypatch.setenv("_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION", "1")
    assert CliRunner().invoke(cli.app, ["--show-completion", "bash"]).exit_code == 0
    monkeypatch.chdir(tmp_path)
    (tmp_path / "quiet.toml").write_text("")
    assert {"quickstart", "quiet.toml"} <= set(scene_names())


@pytest.mark.parametrize(
    ("line", "completed"),
    [
        ("study hur", "hurst"),
        ("study hurst --hu", "--hursts"),
        ("run quick", "quickstart"),
        ("run quickstart --set load.f", "load.force="),
        ("reference --theory yang", "yang-persson"),
    ],
)
def test_names_and_options_are_completed(line, completed):
    asked = {"_FEM_CONTACT_COMPLETE": "complete_bash", "COMP_WORDS": f"fem-contact {line}"}
    asked["COMP_CWORD"] = str(len(line.split()))
    assert CliRunner().invoke(cli.app, env=asked, prog_name="fem-contact").output.strip() == completed


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("run nowhere", "no such scene"),
        ("scenes show quikstart", "no such scene; did you mean 'quickstart'?"),
        ("explain quickstart --set 'yung=3 GPa'", "did you mean 'solid.young'?"),
        ("run quickstart --memory '4 kg'", "--memory = '4 kg': is not a memory size"),
        ("run quickstart --workers 2 --scheduler tcp://x:1", "not together with --scheduler"),
        ("run quickstart --accuracy one", "--accuracy = 'one': must be a share such as 1% or 0.01"),
        ("run quickstart --accuracy 1% --time-limit 0", "--time-limit = '0': must be greater than 0"),
        ("run quickstart --time-limit '3 s'", "--time-limit = '3 s': belongs to --accuracy"),
        ("run quickstart --accuracy 1% --dry-run", "--dry-run: not together with --accuracy"),
        ("run quickstart --accuracy 1% --scheduler tcp://x:1", "--scheduler: not together with --accuracy"),
        ("study --lst", "study --lst: no such option; did you mean '--list'?"),
        ("study presure", "no such study; did you mean 'pressure'?; one of: "),
        ("study area --surfaces", "--surfaces: needs a value"),
        ("study area --hurts 1", "unknown option '--hurts'; did you mean '--hurst"),
        ("study area --set seed=3", "--set seed=3: sets a key of a scene; name one after the study"),
        (
            f"run quickstart --set 'sweep.seed={[*range(65)]}' --set 'sweep.hurst={[0.5] * 65}'",
            "makes 4225 scenes; must be at most",
        ),
        ("study area quickstart --set 'sweep.seed=[1, 2]'", "makes it many scenes; a study is asked"),
        ("validate --method bem hertz", "by all rows; leave out hertz"),
        ("report nowhere", "holds no results (result.json)"),
        ("surface generate quickstart rough.docx", "the suffix must be one of .npy, .txt, .nc, .x3p"),
        ("surface generate quickstart no/where.npy", "not written"),
        ("run quickstart --store /proc/nothing", "--store = '/proc/nothing': cannot be written to"),
    ],
)
def test_a_mistake_is_one_line_on_stderr_and_exit_code_2(tool, line, words):
    code, out, err = tool(line)
    assert code == 2
    assert words in err
    assert err.count("\n") == 1
    assert out == ""


def test_explain_says_what_runs_and_what_is_left_out_and_solves_nothing(done, tmp_path):
    out = done("explain quickstart")
    for words in ("512 x 512", "unknowns", "seconds", "MiB", "adhesion", "hardness", "unknown without"):
        assert words in out
    data = json.loads(done("explain quickstart --json"))
    assert list(tmp_path.iterdir()) == []
    assert {grid["method"] for grid in data["grids"]} == {"bem", "fem"}
    assert data["seconds"] == pytest.approx(sum(grid["seconds"] for grid in data["grids"]))
    assert data["peak_bytes"] == max(grid["peak_bytes"] for grid in data["grids"])


def test_keys_of_a_scene_are_listed_with_unit_meaning_and_default(done):
    listed = done("scenes keys").splitlines()
    young = listed.index('solid.young = "1 GPa"')
    assert listed[young + 1] == "    Young's modulus (plain numbers in Pa); required"
    workers = listed.index("run.workers = 4")
    assert listed[workers + 1].endswith("1 runs everything in the process itself; default: 1")
    assert len(listed) > 150
    assert done("scenes keys 'mean gap'").count("\n") == 2
    # A key that means another thing for another kind of surface is listed for both.
    assert 'surface.lambda_short = "50 nm"    # [surface], kind = "file"' in done("scenes keys noise")
    assert 'sweep.mode = "product"' in done("scenes keys sweep")
    assert "load.mean_gap=" in key_names()


def test_scenes_are_copied_under_a_name_of_their_own(done, mistake, tmp_path):
    done("scenes copy quickstart mine.toml")
    shown = done("scenes show quickstart")
    # Its file names it: with the name of the original it would write over that one's results.
    assert (tmp_path / "mine.toml").read_text() == shown.replace('name = "quickstart"\n', "")
    assert "File exists" in mistake("scenes copy quickstart mine.toml")


@pytest.mark.parametrize(
    ("error", "code", "words"),
    [
        (RunFailed("BEM 8x8: stopped"), 1, "fem-contact: BEM 8x8: stopped\n"),
        (KeyboardInterrupt(), 130, "every finished solve is stored"),
    ],
)
def test_a_failed_solve_and_ctrl_c_have_exit_codes_and_a_sentence(tool, monkeypatch, error, code, words):
    def fails(*args, **kwargs):
        raise error

    monkeypatch.setattr("validation.comparison.run.run_scene", fails)
    ended, _, err = tool("run quickstart -q")
    assert (ended, err.count("\n")) == (code, 1)
    assert words in err


def test_a_dry_run_lists_solves_and_does_none(done, tmp_path):
    heads, *kinds, last = done("run quickstart --dry-run").splitlines()
    assert len(kinds) <= 8
    assert heads.split()[-4:] == ["solves", "stored", "seconds", "MiB"]
    counts, _, seconds, sizes = zip(*(map(float, line.split()[-4:]) for line in kinds), strict=True)
    assert sum(counts) == 57
    assert last.startswith("57 of 57 solves are to be done")
    assert float(re.search(r"in about (\S+) s", last)[1]) == pytest.approx(sum(seconds), rel=0.06)
    rows = json.loads(done("run quickstart --dry-run --json"))
    assert max(sizes) == pytest.approx(max(row["peak_bytes"] for row in rows) / 2**20, rel=0.06)
    assert len(rows) == 57
    assert all(row["seconds"] > 0 and row["peak_bytes"] > 0 and not row["stored"] for row in rows)
    plan = json.loads(done("study area --seed 5 --surfaces 2 --dry-run --json"))
    assert len(plan) == 8 * 2 * 3
    assert list(tmp_path.iterdir()) == []


_LESS = ("--no-ladders", "--methods bem")


def test_a_planned_study_says_what_may_be_left_out(tool):
    options = "--hursts .5 --bandwidths 2 --pairs 2 --ladder-hursts .5 --ladder-pairs 2 --dry-run"
    left_out = r"note: (--[a-z]+(?:-| )[a-z]+) leaves out"
    notes = [re.findall(left_out, tool(f"study hurst {options} {less}")[2]) for less in ("", *_LESS)]
    assert notes == [[*_LESS], [_LESS[1]], [_LESS[0]]]


def test_options_stand_in_the_scene_too_and_the_command_line_goes_before(write_scene, tool, done, tmp_path):
    path = write_scene(
        '[run]\noutput = "there"\nstore = "kept"\nquiet = true\npictures = false\n', SQUARE_CELLS, fem=False
    )
    code, _, err = tool("run", path)
    assert code == 0, err
    assert err == ""
    assert (tmp_path / "there" / "report.html").exists()
    assert len(list((tmp_path / "kept").glob("bem-*.nc"))) == 12
    assert not (tmp_path / "there" / "solves").exists()
    out = done("run", path, "--output", "here", "--no-report")
    assert "Solves done: 0, found finished: 12" in out
    assert all(column in out for column in ("method", "grid", "A/A0, counted", "kappa"))
    assert (tmp_path / "here" / "table.csv").exists()
    assert not (tmp_path / "here" / "report.html").exists()
    summary = json.loads(done("run", path, "--output", "here", "--no-report", "--json"))
    assert summary["kind"] == "run"
    assert summary["findings"][0]["values"]


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("workers = 0", "run.workers = 0"),
        ('memory = "3 m"', "run.memory = '3 m'"),
        ('scheduler = "tcp://x:1"', "run: scheduler: is chosen on the command line alone: --scheduler"),
        ('output = "."', "run.output = '.': must lie below the folder"),
        ('output = "/tmp/elsewhere"', "run.output = '/tmp/elsewhere': must lie below the folder"),
        ('store = "results/../../solves"', "run.store = 'results/../../solves': must lie below the folder"),
        ('output = "link/results"', "'link/results' is a link that leads to"),
        ("worker = 2", "did you mean 'workers'"),
    ],
)
def test_a_wrong_option_in_the_scene_is_named(write_scene, mistake, tmp_path, line, words):
    (tmp_path / "link").symlink_to(tmp_path.parent)
    err = mistake("run", write_scene(f"[run]\n{line}\n"))
    assert words in err


def test_what_a_stranger_named_is_shown_harmlessly(tool, tmp_path):
    np.save(tmp_path / "a\x1b[31m\u202eb.npy", np.ones((3, 3)))
    for command in ("surface inspect 'a\x1b[31m\u202eb.npy'", "run 'a\x1b[31m\u202eb.toml'"):
        code, out, err = tool(command)
        assert code == 2
        assert r"a\x1b[31m\u202eb" in err
        assert "\x1b" not in out + err


def test_links_that_lead_out_of_the_results_are_not_followed(write_scene, tool, done, mistake, tmp_path):
    path, elsewhere, link = write_scene(fem=False), tmp_path / "elsewhere", tmp_path / "results" / "small"
    elsewhere.mkdir()
    link.parent.mkdir()
    link.symlink_to(elsewhere)
    err = mistake("run", path)
    assert "'results/small' is a link that leads to" in err
    assert "say --output 'results/small' to follow it" in err
    link.unlink()
    link.mkdir()
    (link / "solves").symlink_to(elsewhere)
    assert "say --store 'results/small/solves' to follow it" in tool("run", path)[2]
    assert not list(elsewhere.iterdir())
    shutil.rmtree(link.parent)
    # A folder of results may itself be a link to a larger disk.
    link.parent.symlink_to(elsewhere)
    done("run", path, "--dry-run")


def test_a_grid_that_no_memory_holds_is_refused(mistake, tmp_path):
    np.save(tmp_path / "scan.npy", np.random.default_rng(12).normal(size=(8, 8)))
    for line in ("generate quickstart a.npy", "convert scan.npy b.npy --length '1 um' --unit '1 nm'"):
        err = mistake(f"surface {line} --grid 1000000")
        assert "--grid = 1000000: takes 1000000 x 1000000 points and 5.59e+04 GiB" in err


def test_surfaces_are_generated_inspected_and_converted(done, mistake, tmp_path):
    assert "48 x 48 heights" in done("surface generate quickstart rough.nc --grid 48")
    mistake("surface generate quickstart rough.nc")
    facts, scene = (json.loads(done(f"surface inspect {of} --json")) for of in ("rough.nc", "quickstart"))
    assert facts["h'_rms (spectral)"] == pytest.approx(scene["h'_rms (spectral)"], rel=1e-9)
    assert facts["missing points"] == 0
    # Nayak's parameter is one of a periodic map, whose waves are its own.
    assert "Nayak parameter" in facts
    shown = done("surface inspect rough.nc")
    assert "C(q)" in shown
    assert re.search(r"^summits per area: \S+ 1/[mun]?m\^2$", shown, re.M)
    done("surface convert rough.nc rough.txt")
    out = done("surface convert rough.txt rough.npy --length '100 um' --unit '1 m'")
    assert 'it does not say length = [0.0001, 0.0001] (m) and unit = "1 m"' in out
    heights = read_topography(tmp_path / "rough.nc").heights
    np.testing.assert_array_equal(np.load(tmp_path / "rough.npy"), heights)


def test_a_file_that_does_not_say_size_or_unit_is_asked_for_them(tool, done, tmp_path):
    np.save(tmp_path / "scan.npy", np.outer(np.sin(np.arange(16)), np.ones(16)))
    length, unit = "--length: missing, and 'scan.npy' does not say it; size L", "--unit: missing"
    for said, words in (("", (length, unit)), ("--length '1 um'", (unit,)), ("--unit '1 nm'", (length,))):
        code, _, err = tool(f"surface inspect scan.npy {said}")
        assert (code, err.count("\n")) == (2, len(words))
        assert all(line in err for line in words)
    facts = json.loads(done("surface inspect scan.npy --length '1 um' --unit '1 nm' --json"))
    assert facts["h_rms [m]"] == pytest.approx(1e-9 * np.std(np.sin(np.arange(16))), rel=1e-9)
    assert 0.5 < facts["edge jump over typical step"] < 4
    assert "scan.npy: 16 x 16 points" in facts["treatment"]
    np.save(tmp_path / "cut.npy", np.outer(np.linspace(-1.0, 1.0, 64) ** 9, np.ones(48)))
    cut = json.loads(done("surface inspect cut.npy --length '1 um,750 nm' --unit '1 nm' --json"))
    assert cut["points"] == "64 x 48"
    assert {"h'_rms (differences)"} == {key for key in cut if "h'_rms" in key}
    assert "Nayak parameter" not in cut


def test_a_conversion_levels_fills_and_tapers_and_says_so(tool, mistake, tmp_path):
    x, size = np.linspace(0, 1, 40), "--length '10 um' --unit '1 nm'"
    heights = 100 * np.sin(9 * x)[:, None] * np.cos(7 * x)[None, :] + 500 * x[:, None]
    heights[5:8, 9] = np.nan
    np.savetxt(tmp_path / "scan.txt", heights)
    assert "3 of 1600 heights are NaN" in mistake(f"surface convert scan.txt out.nc {size}")
    treatment = "--tilt plane --missing nearest --edges hann"
    code, out, err = tool(f"surface convert scan.txt out.nc {size} {treatment}")
    assert code == 0, err
    assert all(words in err for words in ("plane taken out", "filled: nearest", "hann taper"))
    assert "40 x 40 heights" in out
    mistake("surface convert scan.txt o.nc --length '1 kg'")


def test_studies_and_cases_and_scenes_are_listed_for_people_and_scripts(done):
    assert "--reduced-pressures numbers with commas" in done("study pressure --help")
    assert done("study") == done("study --list") == done("study area --list")
    listed = done("study --list").splitlines()
    assert [sum(line.split()[:1] == [title] for line in listed) for title in ("How", "What")] == [3, 1]
    assert max(map(len, listed)) <= 80
    assert [name for group in GROUPS.values() for name in group if name not in studies()] == []
    assert {line[3:].split()[0] for line in listed if line[:3] in (" * ", "   ")} == set(studies())
    assert "area" in json.loads(done("study --list --json"))
    listed = done("validate --list --quick")
    assert "hertz-bem" in listed
    assert {line.split()[1] for line in listed.splitlines()} == {"quick"}
    assert "quickstart" in json.loads(done("scenes list --json"))


def test_reproduce_prints_the_claims(done, monkeypatch, tmp_path):
    from validation.paper import reproduce
    from validation.paper.claims import STATED, percent

    row = dict(zip(STATED, percent(1.0), strict=True)) | {"claim": "steel: area [nm]", "paper_section": "4"}
    row |= {"computed": 1.01, "literal": 1.01, "paper_verdict": "reproduced"}
    row |= dict.fromkeys(("paper_convention", "paper_reason", "paper_note"), "")
    monkeypatch.setattr(reproduce, "APPLICATIONS", (None,))
    monkeypatch.setattr(reproduce, "FIGURES", ())
    monkeypatch.setattr(reproduce, "judge", lambda application, tell: [row])
    out = done("reproduce --no-figures -q")
    assert "reprod" in out
    assert "[nm]" in out
    assert json.loads(done("reproduce --json"))[0]["computed"] == 1.01


def test_an_accuracy_is_reached_told_and_stored_and_not_solved_again(tool, write_scene, tmp_path):
    path, results = write_scene(fem=False), tmp_path / "results"
    code, out, err = tool("run", path, "--accuracy", "5%", "--no-pictures", "-q")
    assert (code, err) == (0, "")
    assert "Asked for 5 %: A/A0 = " in out
    kept = read_results(results / "small-accuracy")
    data, told = kept.data, kept.settings["accuracy"]
    assert told["error"] <= told["target"] == 0.05
    assert f"\nSolves done: {told['solves']}, found finished: 0." in out
    assert not (results / "small" / "report.html").exists()
    assert data.grid.values.tolist() == [f"{nx} x {ny}" for nx, ny in told["grids"]]
    assert float(data.area_own) == pytest.approx(told["area"], rel=1e-14)
    assert float(data.accuracy_reached) == told["error"]
    assert "asked 5\u00a0%, reached" in (results / "small-accuracy" / "report.html").read_text()
    solver = float(data.area_own_error.sel(source="solver"))
    assert solver == pytest.approx(7 * told["tolerance"] * told["area"], rel=1e-12)
    assert float(total_error(data, "area_own")) == pytest.approx(told["error"] * told["area"], rel=1e-12)
    again = reach(load_scene(str(path)), Bench.at(results / "small" / "solves"), target=told["target"])
    assert (again.solves, again.area, again.error) == (0, told["area"], told["error"])


def test_every_option_of_every_study_says_what_it_is(done, mistake):
    for name, found in studies().items():
        for flag, field in found.options.flags().items():
            assert len(field.description or "") > 2, (name, flag)
        lines = "\n".join(found.help_lines())
        assert "None" not in lines
        assert "default: )" not in lines
    out = done("study hurst --help")
    assert "--equal-nayak a number (may be left out)" in out
    assert "--periods a number (default: " in out
    mistake("study nothing -h")


@pytest.mark.parametrize(
    ("file", "name"), [("mine.toml", "mine"), ("my scene!.toml", "my-scene"), ("äöü.toml", "copy")]
)
def test_a_copied_scene_has_results_of_its_own(tmp_path, file, name):
    target = tmp_path / file
    scenes.copy_scene("quickstart", target)
    copied, original = load_scene(str(target)), load_scene("quickstart")
    assert copied.name == name
    assert copied.model_copy(update={"name": "quickstart"}) == original
    scenes.copy_scene(str(target), again := tmp_path / f"of {file}")  # of a file that may have no name in it
    assert load_scene(str(again)).name == f"of-{name}".removesuffix("-copy")


def test_store_check_verifies_lists_and_sets_aside(tool, done, mistake, tmp_path):
    store, solves = Store(folder=tmp_path / "solves"), [Numbers(k) for k in range(3)]
    solve_all(solves, store)
    assert re.search("3 of 3 solves are intact.*done (on|between)", done("store check", store.folder), re.S)
    path, other = map(store.path, solves[1:])
    path.write_bytes(path.read_bytes()[:-1])
    code, out, err = tool("store check", store.folder, "--list")
    assert code == 1
    assert f"{path.name}: damaged" in out
    assert f"{other.name}: intact" in out
    assert "1 of 3 files are damaged or cannot be read; --set-aside" in err
    out = done("store check", store.folder, "--set-aside", "--json")
    assert [row["intact"] for row in json.loads(out)].count(False) == 1
    assert path.with_suffix(".nc.corrupt").exists()
    assert "2 of 2 solves are intact" in done("store check", store.folder)
    assert "is no folder" in mistake("store check", tmp_path / "nowhere")
