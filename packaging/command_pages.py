#!/usr/bin/python3
"""Writes shell completions and man pages from the program's --help-all.

command_pages.py PROGRAM FOLDER: completions for bash, zsh and fish, and a man page, made by
help2man, for the program and for each command.
"""

import pathlib
import re
import subprocess
import sys


def output_of(program, *words):
    done = subprocess.run([program, *words], capture_output=True, text=True, check=True)
    return done.stdout


def commands_of(program, *words):
    """Yields each command as (words, flags, subcommands), with the description of each."""
    text = re.sub(r"\n {20,}", "  ", output_of(program, *words, "--help-all"))  # wrapped descriptions
    entries = re.findall(r"^  (\S.*?) {2,}(\S.*)$", text, re.MULTILINE)
    below, flags = {}, {}
    for term, said in entries:
        names = re.findall(r"--[\w-]+", term)
        flags |= {name: re.sub(r" {2,}", " ", said) for name in names}
        if not names and f"Usage: {path_of(words)} COMMAND" in text:
            below[term] = re.sub(r" {2,}", " ", said)
    yield words, flags, below
    for name in below:
        yield from commands_of(program, *words, name)


def quoted(text):
    return text.replace("'", "’")


def path_of(words):
    return " ".join(("slipstream", *words))


def shell_script(commands, head, choice, offer):
    """A bash or zsh script: finds the command typed so far, then offers what may follow."""
    known = " | ".join(f"'{path_of(words)}'" for words, _, _ in commands if words)
    cases = [f"    '{path_of(words)}') choices=({' '.join(choice(*one) for one in {**below, **flags}.items())}) ;;"
             for words, flags, below in commands]
    return "\n".join([*head, f'    case "$command $word" in {known}) command="$command $word" ;; esac',
                      "  done", "  case $command in", *cases, "  esac", *offer, ""])


def bash(commands):
    return shell_script(
        commands,
        ["_slipstream() {", "  local command=slipstream word choices=()",
         '  for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do'],
        lambda name, _: name,
        ['  mapfile -t COMPREPLY < <(compgen -W "${choices[*]}" -- "$2")', "}",
         "complete -o default -F _slipstream slipstream"])


def zsh(commands):
    return shell_script(
        commands,
        ["#compdef slipstream", "_slipstream() {", "  local command=slipstream word",
         "  local -a choices", "  for word in ${words[2,CURRENT-1]}; do"],
        lambda name, said: "'" + name + ":" + quoted(said).replace(":", "\\:") + "'",
        ["  _describe slipstream choices", "  _files", "}", '_slipstream "$@"'])


def fish(commands):
    lines = []
    for words, flags, below in commands:
        seen = "; and ".join(f"__fish_seen_subcommand_from {word}" for word in words)
        free = f"not __fish_seen_subcommand_from {' '.join(below)}" if below else ""
        when = "; and ".join(filter(None, [seen, free])) or "true"
        lines += [f"complete -c slipstream -n '{when}' -a {name} -d '{quoted(said)}'"
                  for name, said in below.items()]
        lines += [f"complete -c slipstream -n '{when}' -l {name[2:]} -d '{quoted(said)}'"
                  for name, said in flags.items()]
    return "\n".join([*lines, ""])


def with_name_of_file(text, words, name):
    """The page of a command: help2man writes its words where a page has a name of one word."""
    text = text.replace(path_of(words) + " \\-", name + " \\-", 1)
    return re.sub('^\\.TH .*? "1"', f'.TH {name.upper()} "1"', text, count=1, flags=re.MULTILINE)


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    commands = list(commands_of(program))
    for name, make in [("slipstream.bash", bash), ("_slipstream", zsh), ("slipstream.fish", fish)]:
        (folder / name).write_text(make(commands))
    version = output_of(program, "--version").strip()
    helps = {name: said for _, _, below in commands for name, said in below.items()}
    for words, _, _ in commands:
        page = folder / ("-".join(("slipstream", *words)) + ".1")
        said = helps[words[-1]] if words else "3-D reconstruction by structured light"
        made = subprocess.run(["help2man", "--no-info", "--help-option=--help-all", f"--version-string={version}", "-n", said,
                               " ".join((program, *words))], capture_output=True, text=True,
                              check=True)
        page.write_text(with_name_of_file(made.stdout, words, page.stem))


if __name__ == "__main__":
    main()
