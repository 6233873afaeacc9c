#!/usr/bin/env python3
"""Counts habits that make English hard to read, in comments, docstrings, messages and pages.

tools/plain_english.py            counts each habit; exits with 1 if one is above its limit
tools/plain_english.py --where    lists every occurrence
tools/plain_english.py --sample   prints 30 random comments and 30 random messages (--seed N)
"""

import argparse
import ast
import pathlib
import random
import re
import sys

ROOT = pathlib.Path(__file__).parents[1]
FOLDERS = ("include", "src", "app", "python", "ros", "paper", "bench", "examples", "docs")
CODE = (".h", ".cpp", ".comp", ".glsl", ".js", ".html")

# Habit: pattern, occurrences allowed.
HABITS = {
    "relative clause instead of a noun": (
        r"\bwhat (it|they|is|was|has|are|were|had|a|an|the|its|their|each|one|all|else)\b", 10),
    "of those which": (
        r"\b(of (those|what|which)|that which|those which|"
        r"(of|at|in|to|by|from|with|for|as) that(?= (which|of|where|is|has|are|it)\b|[,.;])|"
        r"(at|in|to|by|from|with|for) those (which|that|of|where))\b|\bthat of\b", 15),
    "none where": (
        r"\b(none|nothing|empty|null|false) where\b|\b(none|nothing) (of|is)\b|"
        r"(?<=[.,;:] )(none|nothing)[.,]|\bwhere (none|not|no|there is)\b", 15),
    "bookish words": (
        r"\b(amiss|anew|likewise|reckon\w*|nobody|somebody|so (many|much|long|often)|but for|"
        r"of itself|wherewith|thereof|therein|hence|alike|save for|lest|whence|thither)\b", 5),
    "no actor": (r"\b(is|are|was|were|be|been|being) (told|said|asked|asked for|warned of)\b", 2),
    "pictures instead of terms": (
        r"\b(glimpse|slip of the hand|hold (its|their) tongue|goes? (its|their) way|at rest)\b", 0),
}


def comments_of(path):
    """The comments of a source as (line, text), lines that follow each other joined."""
    text = path.read_text()
    if path.suffix == ".py":
        tree = ast.parse(text)
        for node in ast.walk(tree):
            if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)):
                if docstring := ast.get_docstring(node):
                    yield (node.body[0].lineno, docstring)
        pattern = r"(?:^|(?<=  ))# ?.*(?:\n[ \t]*# ?.*)*"
    else:
        pattern = r"(?<![:\"'])//(?!/<).*(?:\n[ \t]*//.*)*|///<.*|/\*(?s:.*?)\*/"
    for match in re.finditer(pattern, text, re.M):
        words = re.sub(r"^[ \t]*(///?<?!?|#|/?\*+/?) ?", "", match[0], flags=re.M)
        if not re.match(r"namespace\b", words):
            yield (text.count("\n", 0, match.start()) + 1, words)


def messages_of(path):
    """String literals of three words or more, neighbours joined as compilers join them."""
    text = path.read_text()
    if path.suffix == ".html":
        return
    text = re.sub(r"(?m)(^|[ ;{}])//.*$|^#include.*$", r"\1", text)
    for match in re.finditer(r'"(?:[^"\\\n]|\\.)*"(?:\s*"(?:[^"\\\n]|\\.)*")*', text):
        words = "".join(re.findall(r'"((?:[^"\\]|\\.)*)"', match[0]))
        if len(re.findall(r"[A-Za-z]{2,}", words)) >= 3:
            yield (text.count("\n", 0, match.start()) + 1, words)


def prose_of(path):
    """A page without its blocks of code and code words."""
    text = re.sub(r"^ *```.*?^ *```", lambda block: "\n" * block[0].count("\n"),
                  path.read_text(), flags=re.M | re.S)
    for number, line in enumerate(text.splitlines(), 1):
        yield (number, re.sub(r"`[^`]*`", "", line))


def files():
    inside = [path for folder in FOLDERS for path in sorted((ROOT / folder).rglob("*"))]
    return [*inside, *sorted(ROOT.glob("*.md"))]


def texts_of(path):
    if path.suffix == ".md":
        yield from prose_of(path)
    elif path.suffix == ".py" or path.suffix in CODE:
        yield from comments_of(path)
        if path.suffix != ".py":
            yield from messages_of(path)


def count(where):
    """Occurrences of each habit; `where` prints them."""
    found = dict.fromkeys(HABITS, 0)
    for path in files():
        for line, text in texts_of(path):
            for habit, (pattern, _) in HABITS.items():
                for match in re.finditer(pattern, re.sub(r"\s+", " ", text), re.I):
                    found[habit] += 1
                    if where:
                        context = match.string[max(0, match.start() - 40):match.end() + 40]
                        print(f"{path.relative_to(ROOT)}:{line}: {habit}: ...{context}...")
    return found


def sample(seed, size=30):
    chosen = random.Random(seed)
    sources = [path for path in files() if path.suffix in (*CODE, ".py")]
    for title, texts in (("comments", comments_of), ("messages", messages_of)):
        every = [(path, line, text) for path in sources for line, text in texts(path)]
        print(f"{size} of {len(every)} {title}:")
        for path, line, text in chosen.sample(every, size):
            print(f"- {path.relative_to(ROOT)}:{line}: {' '.join(text.split())}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--where", action="store_true", help="list every occurrence")
    parser.add_argument("--sample", action="store_true", help="print random comments and messages")
    parser.add_argument("--seed", type=int, default=1, help="seed of --sample")
    arguments = parser.parse_args()
    if arguments.sample:
        return sample(arguments.seed)
    found = count(arguments.where)
    for habit, occurrences in found.items():
        print(f"{occurrences:5d} of at most {HABITS[habit][1]:3d}  {habit}")
    return any(found[habit] > HABITS[habit][1] for habit in HABITS)


if __name__ == "__main__":
    sys.exit(main())
