"""``nmap --install-completion``: the files it writes, and how bash, zsh and fish use them."""

import json
import os
import re
import shutil
import subprocess
import sys

import pytest

from nmaptool_cli.command import command_of
from nmaptool_cli.completion import NAMES, SHELLS, completion_script
from nmaptool_cli.main import app

FILES = {
    "bash": [f".local/share/bash-completion/completions/{name}" for name in NAMES],
    "zsh": [f".zsh/completions/_cyclopts_{name}" for name in NAMES],
    "fish": [f".config/fish/completions/{name}.fish" for name in NAMES],
}
VERBS = ["batch", "inspect", "bake", "compare", "preview", "relief", "smooth", "studio", "train"]
EDITS = ["split", "blend", "paste", "depth", "stack", "transform", "convert", "pack", "unpack"]
COMMANDS = [(verb,) for verb in VERBS] + [("compose", edit) for edit in EDITS]
needs_bash = pytest.mark.skipif(os.name == "nt" or shutil.which("bash") is None, reason="needs bash")


@pytest.fixture
def home(tmp_path, monkeypatch):
    """A home directory without any file."""
    for name in ("XDG_DATA_HOME", "XDG_CONFIG_HOME", "BASH_COMPLETION_USER_DIR"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("USERPROFILE", str(tmp_path))
    return tmp_path


@pytest.fixture(scope="module")
def scripts():
    """The completion scripts of every shell for each command name."""
    return {(shell, name): completion_script(shell, name) for shell in SHELLS for name in NAMES}


def flags(words):
    """Every flag of a command, including short ones and those that the parser adds."""
    call = app.parse_commands(list(words))[1][-1].default_command
    found = {"--help", "-h", "--version"}
    for parameter in command_of(call).parameters():
        if parameter.kind is parameter.KEYWORD_ONLY:
            found.update(*(shown.name for shown in parameter.annotation.__metadata__ if shown.name))
    return found


def completed(folder, script, *lines):
    """The completions that bash offers for the last word of each line."""
    ask = 'ask() { COMP_WORDS=("$@"); COMP_CWORD=$(($#-1)); COMPREPLY=(); "_$1"; echo "${COMPREPLY[*]}"; }'
    asked = "\n".join(f"ask {' '.join(words)} '{last}'" for *words, last in lines)
    (folder / "ask.sh").write_text(f"{script}\n{ask}\n{asked}\n", encoding="utf-8", newline="\n")
    done = subprocess.run(["bash", "ask.sh"], cwd=folder, capture_output=True, text=True, check=True)
    assert done.stderr == ""
    return [set(line.split()) for line in done.stdout.splitlines()]


@pytest.mark.parametrize("shell", SHELLS)
def test_one_file_per_name_is_written_and_the_next_step_is_printed(home, run, tree, shell):
    done = run("--install-completion", "--shell", shell)
    paths = [home / name for name in FILES[shell]]
    assert done.code == 0, done.err
    assert {name for name, data in tree().items() if data is not None} == set(FILES[shell])
    lines = done.err.splitlines()
    assert lines[:2] == [f"  wrote {path}" for path in paths]
    assert [line.startswith("  next: ") for line in lines] == [False, False, True]
    assert {"bash": "source ", "zsh": f"fpath=({paths[0].parent} ", "fish": "open a new terminal"}[shell] in lines[2]
    assert paths[1].read_text(encoding="utf-8") == completion_script(shell, "nmaptool")


@pytest.mark.parametrize("shell", SHELLS)
def test_an_existing_file_is_kept_without_overwrite(home, run, refused, shell):
    path = home / FILES[shell][1]
    path.parent.mkdir(parents=True)
    path.write_text("# mine\n", encoding="utf-8")
    refused(
        5, rf"{re.escape(path.as_posix())}: already exists; .*--overwrite", "--install-completion", "--shell", shell
    )
    assert run("--install-completion", "--shell", shell, "--overwrite").code == 0
    assert "# mine" not in path.read_text(encoding="utf-8")


def test_folders_named_by_the_environment_are_used(home, run, monkeypatch, tree):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(home / "config"))
    monkeypatch.setenv("XDG_DATA_HOME", str(home / "data"))
    assert run("--install-completion", "--shell", "fish", "--quiet").err == ""
    report = json.loads(run("--install-completion", "--shell", "bash", "--json").out)
    assert report["shell"] == "bash"
    assert report["outputs"] == [str(home / "data" / "bash-completion" / "completions" / name) for name in NAMES]
    written = [name for name, data in tree().items() if data is not None]
    assert len(written) == 4
    assert all(name.startswith(("config", "data")) for name in written)


@pytest.mark.parametrize(
    ("found", "pattern"),
    [
        ("powershell", r"completion is not available for powershell; name one of bash, zsh, fish"),
        (None, r"cannot tell which"),
    ],
)
def test_other_shells_are_refused_in_one_line(home, monkeypatch, refused, found, pattern):
    import cyclopts.completion as known

    def detect():
        if found is None:
            raise known.ShellDetectionError
        return found

    monkeypatch.setattr(known, "detect_shell", detect)
    refused(2, pattern, "--install-completion")
    refused(2, r'"ksh" for --shell', "--install-completion", "--shell", "ksh")


def test_the_calling_shell_is_found(home, run, monkeypatch, tree):
    for name in ("ZSH_VERSION", "BASH_VERSION"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("FISH_VERSION", "3.6.0")
    assert run("--install-completion").code == 0
    assert set(FILES["fish"]) < set(tree())


@needs_bash
@pytest.mark.parametrize("name", NAMES)
def test_bash_completes_every_command_and_flag(tmp_path, scripts, name):
    lines = [(name, ""), (name, "compose", ""), *((name, *words, "-") for words in COMMANDS)]
    verbs, edits, *found = completed(tmp_path, scripts["bash", name], *lines)
    assert verbs == {*VERBS, "compose"}
    assert edits == set(EDITS)
    for words, offered in zip(COMMANDS, found, strict=True):
        assert offered == flags(words), words


@needs_bash
def test_bash_completes_partial_words_and_values(tmp_path, scripts):
    cases = {
        ("nmap", "ba"): {"bake", "batch"},
        ("nmap", "--inst"): {"--install-completion"},
        ("nmap", "bake", "head.ply", "--filt"): {"--filter"},
        ("nmap", "bake", "--filter", ""): {"rnf", "grnf", "learned"},
        ("nmap", "bake", "--filter", "=", "l"): {"learned"},
        ("nmap", "relief", "map.png", "-o", "a.stl", "--background", "s"): {"surface"},
        ("nmap", "compose", "blend", "--mode", "w"): {"whiteout"},
        ("nmap", "bake", "he"): set(),
    }
    assert completed(tmp_path, scripts["bash", "nmap"], *cases) == list(cases.values())


@needs_bash
def test_bash_completes_file_names_where_any_word_is_allowed(tmp_path, scripts):
    # with these options, bash itself completes file names where the function offers nothing
    script = "".join(scripts["bash", name] for name in NAMES) + "\ncomplete -p nmap nmaptool\n"
    (tmp_path / "ask.sh").write_text(script, encoding="utf-8", newline="\n")
    done = subprocess.run(["bash", "ask.sh"], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == [f"complete -o bashdefault -o default -F _{name} {name}" for name in NAMES]
    assert "compgen -f" not in script


def test_zsh_and_fish_scripts_name_every_command_and_flag(scripts):
    zsh, fish = scripts["zsh", "nmap"], scripts["fish", "nmap"]
    assert zsh.startswith("#compdef nmap\n")
    assert scripts["zsh", "nmaptool"].startswith("#compdef nmaptool\n")
    for words in COMMANDS:
        options = fish.split(f"# Options for: {' '.join(words)}\n")[1].split("\n# ")[0]
        arguments = re.split(rf"\n +{words[-1]}\)\n", zsh)[1].split("_arguments")[1].split(";;")[0]
        for flag in flags(words):
            assert re.search(rf" -[ls] {flag.lstrip('-')} ", options), (words, flag)
            assert re.search(rf"['\"]\*?{flag}\[", arguments), (words, flag)
        assert f"'{words[-1]}:" in zsh
        assert f" -a '{words[-1]}' " in fish
    assert "-l filter -x -a 'rnf grnf learned'" in fish


def test_zsh_has_an_action_for_every_word(scripts):
    specs = re.findall(r"^ +['\"](?:\d:|\*:|\*?-).*$", scripts["zsh", "nmap"], re.MULTILINE)
    takes_word = [spec for spec in specs if re.search(r"\]:|['\"]\d:", spec)]
    assert len(takes_word) > 200
    assert not [s for s in takes_word if not re.search(r":(_files|\([^()]+\)|->\w+)['\"]( \\)?$", s)]
    assert any("--mask[" in spec and spec.endswith(":mask:_files' \\") for spec in takes_word)


@pytest.mark.parametrize("shell", SHELLS)
def test_the_shell_finds_no_syntax_error(tmp_path, scripts, shell):
    if os.name == "nt" or shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed")
    for name in NAMES:
        (tmp_path / name).write_text(scripts[shell, name], encoding="utf-8", newline="\n")
        done = subprocess.run([shell, "-n", name], cwd=tmp_path, capture_output=True, text=True, check=False)
        assert (done.returncode, done.stderr) == (0, "")


def test_pressing_tab_does_not_start_python(scripts):
    assert not [key for key, script in scripts.items() if "__complete" in script or sys.executable in script]


@pytest.mark.parametrize("words", [["--help"], ["inspect", "--help"]])
def test_other_commands_do_not_load_completion(words):
    code = f"import sys; from nmaptool_cli.main import main; main({words}); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, encoding="utf-8", check=True)
    loaded = done.stdout.splitlines()[-1].split()
    assert "nmaptool_cli.main" in loaded
    assert not [name for name in loaded if name == "nmaptool_cli.completion" or name.startswith("cyclopts.completion")]
