"""What stands around the driver: the Makefile's variables, the set-up, the batch script, kept and deleted runs."""

import gzip
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import sysconfig
import time
from pathlib import Path

import pytest
from driver import FAKE, ROOT, copy_run, drive, read_record, results_of, run_folder, wait_until

from analysis.driver import keep
from analysis.driver.locks import hold
from analysis.scenarios import study_list

SHOW = f"{sys.executable} -c 'import sys; print(sys.argv[1:])'"
AWKWARD = (
    "$(touch x)",
    "$(shell touch x)",
    "`touch x`",
    "a b",
    "it's",
    'say "so"',
    "x;touch x",
    "#half",
    "$HOME",
    "a&b|c>d",
)


ODD_FOLDER = "it's a $HOME #1 näch%te"


def make(*arguments, **options):
    """Run make without its set-up; commands of the analysis print their arguments instead."""
    command = ["make", "--no-print-directory", "-o", "setup", "-o", ".venv/installed", f"ANALYSIS={SHOW}", *arguments]
    options = {"cwd": ROOT, "timeout": 60} | options
    return subprocess.run(command, capture_output=True, text=True, check=False, **options)


@pytest.mark.parametrize("value", AWKWARD)
def test_a_variable_of_make_reaches_the_command_as_it_was_typed(value):
    variables = {"RESULTS": "--results", "BED": "--bed", "SEED": "--seed", "PROFILE": "--profile", "SCENARIO": "--"}
    typed = make("run", *(f"{name}={value}" for name in variables))
    inherited = make("run", env=os.environ | dict.fromkeys(variables, value))
    for done in (typed, inherited):
        assert done.returncode == 0, done.stderr
        assert all(repr(f"{option}={value}") in done.stdout for option in variables.values() if option != "--")
        assert done.stdout.endswith(f"'--', {value!r}]\n")
    assert not (ROOT / "x").exists()


def test_no_recipe_hands_a_variable_to_the_shell_as_code():
    """Whatever `make` is asked for, a value stays a value: RESULTS in every target that reads it, Python's path too."""
    text = (ROOT / "Makefile").read_text()
    names = re.search(r"^VARIABLES := (.*)$", text, re.MULTILINE)[1].split()
    assigned = re.findall(r"^(\w+) +\?=", text, re.MULTILINE)
    assert sorted(names) == sorted(assigned)  # each variable that a user may give is handed over like that
    recipes = [line for line in text.splitlines() if line.startswith("\t")]
    assert not [line for line in recipes if re.search(rf"\$[({{](?:{'|'.join(names)})[)}}]", line)]
    targets = (
        "status",
        "compare",
        "findings",
        "unload",
        "keep",
        "distclean-run",
        "calibrate",
        "timestep",
        "bench",
        "view",
    )
    for value in AWKWARD:
        done = make(*targets, f"RESULTS={value}")
        assert done.returncode == 0, done.stderr
        assert [repr(f"--results={value}") in line for line in done.stdout.splitlines()] == [True] * len(targets)
    assert not (ROOT / "x").exists()


@pytest.mark.parametrize("value", AWKWARD)
def test_a_scenario_of_any_name_reaches_every_command_as_it_was_typed(value):
    done = make("keep", "view", "distclean-run", "impact", f"SCENARIO={value}", f"CASE={value}")
    assert [line.endswith(f"'--', {value!r}]") for line in done.stdout.splitlines()] == [True] * 4
    if "$" not in value:  # make itself reads a dollar in the name of a target
        assert make(f"yade-{value}").stdout.endswith(f"'--', {value!r}]\n")
    assert not (ROOT / "x").exists()


@pytest.mark.parametrize("jobs", ["-j1", "-j8"])
def test_the_demo_is_one_bed_three_runs_of_each_code_and_then_the_report_however_many_jobs(jobs):
    for _ in range(2):  # also the second time
        done = make("demo", jobs, "MAKE=make -o setup -o .venv/installed")  # -o is not handed down
        assert done.returncode == 0, done.stderr
        # not line by line: what runs at the same time may share a line
        packing, *runs = re.findall(r"\['run', '([^']+)', '--code=(\w+)'", done.stdout)
        assert packing == ("linear-mu0.8", "liggghts") and done.stdout.count("'--until=packing'") == 1
        names = ("linear-mu0.8", "nonlinear-en1.0", "nonlinear-en1.0+servo")
        asked = [(name, "liggghts") for name in names] + [(f"{name}+same-bed", "yade") for name in names]
        assert sorted(runs) == sorted(asked)
        assert done.stdout.count("'--profile=demo'") == 7
        assert done.stdout.splitlines()[-1].startswith("['report', '--demo'")


def test_yade_runs_fewer_cycles_of_the_demo_unless_cycles_are_given():
    done = make("demo")
    assert len(re.findall(r"same-bed', '--code=yade'[^\]]*'--cycles=\d+'", done.stdout)) == 3
    assert done.stdout.count("--cycles=") == 3 and make("demo", "CYCLES=1").stdout.count("'--cycles=1'") == 7


# ---------------------------------------------------------------------- set-up


@pytest.fixture
def copy(tmp_path):
    """A checkout's set-up files, in a folder with a space, and a Python that makes environments without packages."""
    folder = tmp_path / "my study"
    folder.mkdir()
    for name in ("setup.sh", "pyproject.toml", "README.md"):
        shutil.copy(ROOT / name, folder)
    (folder / "results").mkdir()
    (folder / "results" / "run.json").write_text("precious")
    return folder


def set_up(folder, word):
    return subprocess.run(
        ["bash", folder / "setup.sh", word], capture_output=True, text=True, timeout=60, check=False, cwd="/"
    )


@pytest.mark.parametrize("damage", ["nothing there", "link to a Python that is gone", "packages of another Python"])
def test_an_environment_that_cannot_be_used_is_noticed(copy, damage):
    binaries = copy / ".venv" / "bin"
    if damage != "nothing there":
        binaries.mkdir(parents=True)
        (copy / ".venv" / "installed").touch()
        (binaries / "python").symlink_to("/nowhere/python3.10" if "link" in damage else "/usr/bin/true")
    if "packages" in damage:  # it starts, but cannot load what was installed
        (binaries / "python").unlink()
        (binaries / "python").write_text('#!/bin/sh\nexec python3 -I -S "$@"\n')
        (binaries / "python").chmod(0o755)
    assert "cannot be used" in set_up(copy, "works").stdout


def test_a_broken_environment_is_made_anew_and_results_stay(copy):
    binaries = copy / ".venv" / "bin"
    binaries.mkdir(parents=True)
    (binaries / "python").symlink_to("/nowhere/python3.10")
    (copy / ".venv" / "installed").touch()
    # a pip that installs nothing: what is tested is that it comes to be asked, in a new environment
    (copy / "sitecustomize.py").write_text("")
    made = subprocess.run(
        ["bash", copy / "setup.sh", "environment"],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        env=os.environ | {"PIP_NO_INDEX": "1", "PIP_FIND_LINKS": str(copy), "PYTHON": sys.executable},
    )
    assert "made anew" in made.stdout and "pip could not install" in made.stderr  # this test has no package index
    assert (binaries / "python").exists() and not (copy / ".venv" / "installed").exists()
    assert (copy / "results" / "run.json").read_text() == "precious"


def test_a_checkout_in_a_folder_with_a_colon_is_refused_in_one_line(copy):
    moved = copy.rename(copy.with_name("my:study"))
    done = set_up(moved, "packages")
    assert done.returncode == 1 and done.stdout == "" and len(done.stderr.splitlines()) == 1
    assert "has a colon" in done.stderr and not (moved / ".venv").exists()


@pytest.mark.parametrize("has_dpkg", [False, True])
def test_packages_that_cannot_be_installed_are_named_with_a_remedy(copy, tmp_path, has_dpkg):
    """On another system, or where apt-get or sudo refuses."""
    programs = {"dpkg-query": "exit 1", "apt-get": "exit 100", "sudo": "exit 1"} if has_dpkg else {}
    binaries = tmp_path / "bin"
    binaries.mkdir()
    for name in ("dirname", "env"):
        (binaries / name).symlink_to(shutil.which(name))
    for name, text in programs.items():
        (binaries / name).write_text(f"#!{shutil.which('sh')}\n{text}\n")
        (binaries / name).chmod(0o755)
    done = subprocess.run(
        [shutil.which("bash"), copy / "setup.sh", "packages"],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        env={"PATH": str(binaries)},
    )
    said = "could not install yade liggghts" if has_dpkg else "not a Debian system; install by hand: yade liggghts"
    assert done.returncode == 1 and len(done.stderr.splitlines()) == 1 and said in done.stderr, done.stderr


def test_the_environment_of_this_checkout_works():
    assert set_up(ROOT, "works").stdout == ""


@pytest.mark.parametrize("name", ["$HOME", "it's", 'a "b"', "half #1", "näch%te", "`touch x`"])
def test_the_command_of_the_environment_works_in_any_folder_and_through_a_link(tmp_path, name):
    binaries = tmp_path / name / ".venv" / "bin"
    binaries.mkdir(parents=True)
    shutil.copy(Path(sys.executable).parent / "ballast", binaries)
    (binaries / "python").write_text('#!/bin/sh\nprintf "%s|" "$@"\n')
    (binaries / "python").chmod(0o755)
    (tmp_path / "link").symlink_to(binaries / "ballast")
    for command in (binaries / "ballast", tmp_path / "link"):
        done = subprocess.run([command, "a b", "$HOME"], cwd=tmp_path, capture_output=True, text=True, timeout=60)
        assert done.stdout == "-m|analysis|a b|$HOME|" and done.returncode == 0, done.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([name, "link"])


def test_make_works_in_a_checkout_of_any_name(tmp_path):
    checkout = tmp_path / ODD_FOLDER
    checkout.mkdir()
    for name in ("Makefile", "setup.sh", "pyproject.toml"):
        shutil.copy(ROOT / name, checkout)
    done = make("report", "status", cwd=checkout)
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    assert done.stdout.splitlines() == ["['report', '--results=results']", "['status', '--results=results']"]


def test_the_host_is_built_again_when_the_library_is_another_one(tmp_path):
    host = tmp_path / ODD_FOLDER / "liggghts"
    library = host / "build" / "library"
    shutil.copytree(ROOT / "liggghts", host, ignore=shutil.ignore_patterns("build"))

    def due() -> bool:
        done = subprocess.run(["make", "-C", host, "-q", "build/main.o"], check=False, capture_output=True)
        return done.returncode != 0

    def built() -> None:
        subprocess.run(["make", "-C", host, "build/library"], check=True, capture_output=True)

    built()
    before = library.read_text()
    (host / "build" / "main.o").touch()
    os.utime(library, (1, 1))
    built()
    assert library.stat().st_mtime == 1, "the same library is no reason to build"
    library.write_text("another release\n")
    os.utime(library, (1, 1))
    built()
    assert library.read_text() == before and library.stat().st_mtime > 1 and due()


def test_a_yade_without_a_class_that_is_needed_names_it_in_one_line(tmp_path):
    """Debian 13 builds YADE without PARTIALSAT; another build may leave out more."""
    wanted = set(re.findall(r"^        (\w+),$", (ROOT / "yade" / "contact.py").read_text(), re.MULTILINE))
    assert {"FrictViscoMat", "MindlinPhys"} <= wanted and not any("PartialSat" in name for name in wanted)
    package = tmp_path / "yade"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "wrapper.py").write_text("".join(f"{name} = object\n" for name in wanted - {"FrictViscoMat"}))
    code = f"import sys; sys.path[:0] = [{str(tmp_path)!r}, {str(ROOT / 'yade')!r}]; import contact"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 1 and done.stderr == "" and len(done.stdout.splitlines()) == 1
    assert done.stdout.startswith("ERROR: yade: cannot import name 'FrictViscoMat'")


# ---------------------------------------------------------------------- Slurm

STAND_IN = """#!/bin/sh
trap '' TERM
echo started > started
while [ ! -f end ]; do sleep 0.05; done
echo written > checkpoint
exit 143
"""
OF_THE_FAKE_ENGINE = """#!/bin/sh
echo "$@" >> asked_of_python
exec '{python}' '{driver}' linear-mu0.8 --code yade --cycles 30 --results results
"""
ALONE = {"SLURM_JOB_ID": "7"}
IN_AN_ARRAY = {"SLURM_JOB_ID": "9", "SLURM_ARRAY_JOB_ID": "7", "SLURM_ARRAY_TASK_ID": "3"}


@pytest.fixture
def submit(tmp_path):
    """Function that starts slurm.sh as a node does: a copy of it, elsewhere, told where it was submitted."""
    where = tmp_path / "a checkout"
    spool = tmp_path / "spool" / "slurm_script"
    spool.parent.mkdir()
    shutil.copy(ROOT / "slurm.sh", spool)

    def job(environment, python, scontrol="exit 0"):
        (where / "analysis").mkdir(parents=True, exist_ok=True)
        programs = ((where / ".venv" / "bin" / "python", python), (spool.parent / "scontrol", SCONTROL + scontrol))
        for path, text in programs:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
            path.chmod(0o755)
        told = {"SLURM_SUBMIT_DIR": str(where), "PATH": f"{spool.parent}:{os.environ['PATH']}"}
        return where, subprocess.Popen(
            ["bash", spool], cwd=spool.parent, env=os.environ | told | environment, stdout=subprocess.PIPE,
            stderr=subprocess.PIPE, text=True,
        )  # fmt: skip

    return job


SCONTROL = '#!/bin/sh\necho "$@" > asked\n'


@pytest.mark.parametrize("environment, asked", [(ALONE, "requeue 7"), (IN_AN_ARRAY, "requeue 7_3")])
def test_a_batch_job_waits_for_the_checkpoint_and_is_queued_again(submit, environment, asked):
    where, job = submit(environment, STAND_IN)
    wait_until((where / "started").exists, "the run did not start")
    for _ in range(3):
        job.send_signal(signal.SIGTERM)
        time.sleep(0.1)
    assert job.poll() is None and not (where / "checkpoint").exists()
    (where / "end").touch()
    assert job.wait(300) == 0
    assert (where / "checkpoint").exists() and (where / "asked").read_text().strip() == asked


@pytest.mark.parametrize("environment, number", [(ALONE, "0"), (IN_AN_ARRAY, "3")])
def test_a_batch_job_that_was_queued_again_ends_with_the_files_of_one_that_nobody_stopped(
    submit, tmp_path, environment, number
):
    python = OF_THE_FAKE_ENGINE.format(python=sys.executable, driver=ROOT / "tests" / "fake_driver.py")
    where, job = submit(environment, python)
    folder = run_folder(where / "results", "linear-mu0.8", "yade")
    wait_until((folder / "cycles.csv").exists, "no cycle")
    job.send_signal(signal.SIGTERM)
    out, err = job.communicate(timeout=600)
    assert job.returncode == 0 and (where / "asked").exists() and read_record(folder)["state"] == "interrupted", err
    (where / "asked").unlink()
    where, job = submit(environment, python)
    out, err = job.communicate(timeout=600)
    assert job.returncode == 0 and not (where / "asked").exists() and read_record(folder)["state"] == "finished", err
    assert (where / "asked_of_python").read_text() == f"-m analysis study --array {number}\n" * 2
    done = drive(FAKE, "linear-mu0.8", "--code", "yade", "--cycles", 30, "--results", tmp_path / "calm")
    assert done.returncode == 0, done.stderr
    assert results_of(folder) == results_of(run_folder(tmp_path / "calm", "linear-mu0.8", "yade"))


def test_a_batch_job_that_cannot_be_queued_again_or_fails_says_so(submit):
    _, job = submit(ALONE, "#!/bin/sh\nexit 143\n", scontrol="exit 1")
    out, err = job.communicate(timeout=300)
    assert job.returncode == 143 and len(err.splitlines()) == 1 and "job 7 could not be queued again" in err
    where, job = submit(IN_AN_ARRAY, "#!/bin/sh\nexit 1\n")
    (where / "asked").unlink()
    assert job.wait(300) == 1 and not (where / "asked").exists()  # a failure is an end, not a reason to try again


def test_a_batch_job_submitted_elsewhere_is_refused_in_one_line(submit, tmp_path):
    for place in (tmp_path / "spool", tmp_path / "nowhere"):
        _, job = submit({"SLURM_SUBMIT_DIR": str(place)}, STAND_IN)
        out, err = job.communicate(timeout=300)
        assert job.returncode == 1 and len(err.splitlines()) == 1 and str(place) in err


def test_the_array_of_the_batch_script_is_the_study():
    last = re.search(r"^#SBATCH --array=0-(\d+) ", (ROOT / "slurm.sh").read_text(), re.MULTILINE)
    assert int(last[1]) + 1 == len(study_list.final_rows())


def test_shellcheck_finds_nothing_in_the_shell_scripts():
    scripts = sorted(ROOT.glob("*.sh"))
    assert [path.name for path in scripts] == ["setup.sh", "slurm.sh"]
    shellcheck = Path(sysconfig.get_path("scripts")) / "shellcheck"
    done = subprocess.run([shellcheck, *scripts], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stdout


# ---------------------------------------------------------------------- kept and deleted runs


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    """Results with one finished run of one cycle."""
    results = tmp_path_factory.mktemp("short")
    done = drive(FAKE, "linear-mu0.8", "--code", "yade", "--cycles", 1, "--results", results)
    assert done.returncode == 0, done.stderr
    return results


@pytest.fixture
def run(short, tmp_path):
    """A copy of that run, and where it would be kept."""
    folder = copy_run(
        run_folder(short, "linear-mu0.8", "yade"), run_folder(tmp_path / "results", "linear-mu0.8", "yade")
    )
    return folder, run_folder(tmp_path / "kept", "linear-mu0.8", "yade")


def command(name, run, *more):
    results = run[0].parent.parent.parent
    out = ["--out", run[1].parent.parent.parent] if name == "keep" else []
    return (FAKE[0], "-m", "analysis", name), "linear-mu0.8", "--code", "yade", "--results", results, *out, *more


def change_state(folder, **changes):
    (folder / "run.json").write_text(json.dumps(read_record(folder) | changes))


def test_keep_says_what_it_kept_and_leaves_nothing_of_an_older_keep(run):
    folder, target = run
    target.mkdir(parents=True)
    (target / "microstructure_of_old.csv").write_text("old")
    done = drive(*command("keep", run))
    assert done.returncode == 0 and "finished, 1 of 1 cycles" in done.stdout
    there = [name for name in keep.FILES if (folder / name).exists()]
    assert {"run.json", "cycles.csv"} < set(there)
    assert sorted(path.name for path in target.iterdir()) == sorted(
        [*there, "harmonics.csv", "loops.csv", "plates.csv"]
    )
    assert all((target / name).read_bytes() == (folder / name).read_bytes() for name in there)
    assert [path.name for path in target.parent.iterdir()] == [target.name]


def test_the_packed_bed_of_the_study_is_kept_for_others_to_start_from(run):
    folder, target = run
    beds = target.parents[2] / "beds"
    packed = folder / "raw" / "bed_packed.csv"
    assert keep.keep_bed(folder, beds) is None and not beds.exists(), "a bed of the test profile is not the study's"
    change_state(folder, profile="full", seed=2)
    kept = keep.keep_bed(folder, beds)
    assert kept == beds / "yade-seed2.csv.gz" and gzip.decompress(kept.read_bytes()) == packed.read_bytes()
    assert [path.name for path in beds.iterdir()] == [kept.name]
    change_state(folder, bed="linear-mu0.8/liggghts")
    assert keep.keep_bed(folder, beds) is None, "the bed is another run's"


def test_a_failed_run_is_kept_only_when_asked(run):
    folder, target = run
    change_state(folder, state="failed", reason="diverged: overlap")
    done = drive(*command("keep", run))
    assert done.returncode == 1 and "has failed (diverged: overlap); --failed keeps it" in done.stderr
    assert not target.exists()
    done = drive(*command("keep", run, "--failed"))
    assert done.returncode == 0 and "failed, 1 of 1 cycles (diverged: overlap)" in done.stdout


def test_a_run_in_progress_is_not_kept(run):
    folder, target = run
    change_state(folder, state="running")
    with hold(folder / "run.lock"):
        done = drive(*command("keep", run))
    assert done.returncode == 1 and "is running" in done.stderr and not target.exists()


def test_a_keep_that_fails_leaves_the_older_one_as_it_was(run):
    folder, target = run
    assert drive(*command("keep", run)).returncode == 0
    before = {path.name: path.read_bytes() for path in target.iterdir()}
    change_state(folder, title="another")
    (folder / "microstructure.csv").unlink()
    (folder / "microstructure.csv").mkdir()  # cannot be copied
    done = drive(*command("keep", run))
    assert done.returncode == 1 and len(done.stderr.splitlines()) == 1 and "nothing was kept" in done.stderr
    assert {path.name: path.read_bytes() for path in target.iterdir()} == before
    assert [path.name for path in target.parent.iterdir()] == [target.name]


def test_what_is_no_whole_result_is_not_kept(run):
    (run[0] / "stages.json").unlink()
    done = drive(*command("keep", run))
    assert done.returncode == 1 and "stages.json: is missing" in done.stderr and not run[1].exists()


def test_a_run_is_deleted_only_after_yes_and_never_while_it_runs(run):
    folder, _ = run
    (arguments, *more) = command("delete", run)
    ask = [*arguments, *map(str, more)]

    def answer(text):
        return subprocess.run(ask, cwd=ROOT, input=text, capture_output=True, text=True, timeout=60, check=False)

    assert answer("no\n").returncode == 1 and (folder / "cycles.csv").exists()
    with hold(folder / "run.lock"):
        done = answer("yes\n")
        assert done.returncode == 1 and "is running" in done.stderr and (folder / "cycles.csv").exists()
    assert answer("yes\n").returncode == 0 and not folder.exists()


def test_a_run_with_variants_is_kept_under_its_id(run):
    folder, target = run
    varied = folder.parent.with_name("linear-mu0.8+half-step+servo")
    folder.parent.rename(varied)
    done = drive(*command("keep", (varied / "yade", target), "--variant", "servo,half-step"))
    assert done.returncode == 0, done.stderr
    assert (target.parent.with_name("linear-mu0.8+half-step+servo") / "yade" / "cycles.csv").exists()
