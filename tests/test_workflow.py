"""The continuous-integration workflow runs the checks of `make test` and installs the packages of setup.sh."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[1]
WORKFLOW = (ROOT / ".github" / "workflows" / "test.yml").read_text(encoding="utf-8")


def recipe(target):
    """The shell commands of a Makefile target."""
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8").replace("$(BIN)", "$BIN").replace("$(VENV)", ".venv")
    makefile = makefile.replace("$(JOBS)", "auto")
    return re.findall(r"^\t(.*)$", makefile.split(f"\n{target}: ")[1].split("\n\n")[0], re.MULTILINE)


def test_the_commands_match_the_makefile():
    commands = [line.strip().removeprefix("run: ") for line in WORKFLOW.splitlines()]
    assert len(recipe("check")) >= 4
    assert [command for command in (*recipe("check"), *recipe("test")) if command not in commands] == []


def test_every_supported_python_is_tested_on_three_systems():
    assert re.search(r"^ +os: \[ubuntu-latest, macos-latest, windows-latest\]$", WORKFLOW, re.MULTILINE)
    tried = re.search(r"^ +python: \[(.*)\]$", WORKFLOW, re.MULTILINE)[1]
    accepted = re.search(r"python3\.13 .*? python3 ", (ROOT / "setup.sh").read_text(encoding="utf-8"))[0]
    assert sorted(re.findall(r"3\.\d+", tried)) == sorted(re.findall(r"3\.\d+", accepted))


def test_the_system_packages_match_setup():
    libraries = re.search(r'install="apt-get install -y (lib.*)"', (ROOT / "setup.sh").read_text(encoding="utf-8"))[1]
    assert f"apt-get install -y {libraries} " in WORKFLOW
    assert '--only-binary :all: --no-binary pyopengl"' in WORKFLOW
