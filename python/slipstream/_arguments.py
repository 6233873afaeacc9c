"""One line for arguments that pybind11 refuses: which one is wrong, and its types.

pybind11 itself lists the signature and every value. The types come from the docstrings, which the
stub has too."""

import ast
import difflib
import functools
import inspect
import numbers
import os
import re

from . import _slipstream

# What values are of a docstring's type; of all other types only pybind11 knows.
KNOWN_TYPES = {"None": type(None), "bool": bool, "int": numbers.Integral, "float": numbers.Real,
               "str": str, "Literal": str, "PathLike": (str, os.PathLike)}


def may_be(value, kind):
    """Whether a value is of a docstring's type, such as `Scan | str`; True if that is unknown."""
    without_brackets = re.sub(r"\[[^\[\]]*\]", "", kind)
    while without_brackets != kind:
        kind, without_brackets = without_brackets, re.sub(r"\[[^\[\]]*\]", "", without_brackets)

    for name in kind.split(" | "):
        known = KNOWN_TYPES.get(name) or getattr(_slipstream, name, None)
        if known is None or isinstance(value, known):
            return True
    return False


def types_in(doc):
    """The types of a docstring's arguments by name."""
    section = doc.partition("Args:\n")[2].partition("\n\n")[0]
    entries = re.findall(r"^ +(\w+) \((.*?)(?:, default .*?)?\):(?: |$)", section, re.MULTILINE)
    return dict(entries)


def refusal(title, signature, doc, given, named):
    """Why these arguments cannot be taken."""
    arguments = ast.parse(f"def {signature}: ...").body[0].args
    in_order = [one.arg for one in arguments.args]
    if in_order[:1] == ["self"]:
        in_order, given = in_order[1:], given[1:]
    only_named = [one.arg for one in arguments.kwonlyargs]
    kinds = types_in(doc)

    # 1. Too many of them, or with an unknown name.
    if len(given) > len(in_order):
        names = ", ".join(f"{name}=..." for name in kinds)
        advice = f"; name them: {names}" if names else ""
        return f"{title}: takes {len(in_order)} arguments without a name, not {len(given)}{advice}"

    for name in named:
        if name not in in_order + only_named and not arguments.kwarg:
            near = difflib.get_close_matches(name, in_order + only_named, 1)
            advice = f"did you mean {near[0]}?" if near else f"it takes {', '.join(kinds)}"
            return f"{title}: unknown argument '{name}'; {advice}"

    # 2. One that is missing.
    values = {**dict(zip(in_order, given)), **named}
    required = in_order[:len(in_order) - len(arguments.defaults)]
    required += [one for one, default in zip(only_named, arguments.kw_defaults) if default is None]
    for name in required:
        if name not in values:
            return f"{title}: {name} is missing; expected {kinds.get(name, 'a value')}"

    # 3. One of the wrong type, or all of them if it is unclear which.
    for name, value in values.items():
        if name in kinds and not may_be(value, kinds[name]):
            return f"{title}: {name} cannot be {_slipstream._shown(value)}; expected {kinds[name]}"

    got = ", ".join(f"{name} {_slipstream._shown(value)}" for name, value in values.items())
    expected = ", ".join(f"{name} {kinds[name]}" for name in values if name in kinds)
    return f"{title}: cannot take {got}; expected {expected}"


def is_from_pybind(message):
    return re.match(r"\w*\(\): incompatible ", message)


def explained(call, explanation):
    """The same function, with another TypeError where the explanation of its message has one."""
    @functools.wraps(call)
    def explaining(*given, **named):
        try:
            return call(*given, **named)
        except TypeError as error:
            message = explanation(str(error), given, named)
            if message is None:
                raise
            raise TypeError(message) from None
    return explaining


def explained_call(title, call, doc):
    signature = call.__doc__.partition("\n")[0]

    def explanation(message, given, named):
        if is_from_pybind(message):
            return refusal(title, signature, doc, given, named)

        # A setting of **kwargs.
        name = message.partition(" cannot be ")[0]
        kind = types_in(doc).get(name)
        return f"{message}; expected {kind}" if kind and "; expected " not in message else None

    explaining = explained(call, explanation)
    explaining.__qualname__ = title.removesuffix("()")  # pickle looks for it there
    return explaining


def explained_property(name, member):
    def explanation(message, given, _):
        if not is_from_pybind(message):
            return None
        kind = member.__doc__.partition(":")[0]
        return f"{name} cannot be {_slipstream._shown(given[1])}; expected {kind}"

    return property(member.fget, explained(member.fset, explanation), doc=member.__doc__)


def explain_members(bound):
    """Of a class: its constructor, methods and attributes that can be set."""
    for name, member in list(vars(bound).items()):
        if name == "__init__" and member.__doc__.startswith("__init__("):
            explaining = explained_call(f"{bound.__name__}()", member, bound.__doc__)
        elif isinstance(member, property) and member.fset:
            explaining = explained_property(name, member)
        elif name.startswith("_") or isinstance(member, property):
            continue
        elif isinstance(member, staticmethod):
            call = member.__func__
            title = f"{bound.__name__}.{name}()"
            explaining = staticmethod(explained_call(title, call, call.__doc__))
        else:
            explaining = explained_call(f"{bound.__name__}.{name}()", member, member.__doc__)
        setattr(bound, name, explaining)


def explain(names):
    """Explains refused arguments of all public functions and classes of `_slipstream` in `names`."""
    for name, bound in list(names.items()):
        if name.startswith("_") or bound is not getattr(_slipstream, name, None):
            continue
        if not isinstance(bound, type):
            if inspect.isroutine(bound):
                names[name] = explained_call(f"{name}()", bound, bound.__doc__)
        elif not issubclass(bound, Exception):
            explain_members(bound)
