"""Every mutant of one source file: mutmut's operators on the whole file, module level included, and table cells swapped.

mutmut's own command mutates functions only, but our limits, defaults and tables stand at module level; so its operators are
used as a library. Left out: changed upper and lower case (a string gets one mutant), decorated functions, annotations.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import libcst as cst
from libcst.metadata import MetadataWrapper
from mutmut.mutation.file_mutation import MutationVisitor, OuterFunctionProvider
from mutmut.mutation.mutators import mutation_operators
from mutmut.mutation.pragma_handling import IgnoredCode

NOTHING_LEFT_OUT = IgnoredCode(set(), set(), set())  # no pragma saves a line


class Mutant(NamedTuple):
    scope: str  # the function it is in; "" at module level
    was: str  # the lines that differ, without indentation
    becomes: str
    code: str  # the whole mutated file

    @property
    def name(self) -> str:
        return f"{self.scope or 'module'}: {self.was}  ->  {self.becomes}"


def mutants_of(code: str) -> list[Mutant]:
    """In the order of the file; two that give the same file are one."""
    found = {mutated: scope for scope, mutated in (*_by_operators(code), *_by_cells(code)) if mutated != code}
    return [Mutant(scope, *_difference(code, mutated), mutated) for mutated, scope in found.items()]


def _by_operators(code: str) -> Iterator[tuple[str, str]]:
    wrapper = MetadataWrapper(cst.parse_module(code))
    outer = wrapper.resolve(OuterFunctionProvider)
    visitor = MutationVisitor(mutation_operators, NOTHING_LEFT_OUT)
    module: Any = wrapper.visit(visitor)
    for mutation in visitor.mutations:
        if not _is_case_change(mutation.original_node, mutation.mutated_node):
            around = outer.get(mutation.original_node)
            scope = around.name.value if isinstance(around, cst.FunctionDef) else ""
            yield scope, module.deep_replace(mutation.original_node, mutation.mutated_node).code


def _is_case_change(original: Any, mutated: Any) -> bool:
    both = isinstance(original, cst.SimpleString) and isinstance(mutated, cst.SimpleString)
    return both and bool(original.value.lower() == mutated.value.lower())


def _by_cells(code: str) -> Iterator[tuple[str, str]]:
    """A table written as text, `_NAME = \"""...\"""`: in every row each cell changes places with the next that differs."""
    lines = code.split("\n")
    inside = False
    for number, line in enumerate(lines):
        if inside and line.startswith('"""'):
            inside = False
        if inside:
            for swapped in _swaps(line):
                yield "", "\n".join((*lines[:number], swapped, *lines[number + 1 :]))
        if line.endswith(' = """'):
            inside = True


def _swaps(line: str) -> Iterator[str]:
    name, *cells = line.split()
    for place in range(len(cells) - 1):
        if cells[place] != cells[place + 1]:
            yield "  ".join((name, *cells[:place], cells[place + 1], cells[place], *cells[place + 2 :]))


def _difference(code: str, mutated: str) -> tuple[str, str]:
    """The lines that differ: everything between the common beginning and the common end."""
    before, after = code.splitlines(), mutated.splitlines()
    head = next((i for i, (a, b) in enumerate(zip(before, after, strict=False)) if a != b), min(len(before), len(after)))
    rest_before, rest_after = before[head:], after[head:]
    while rest_before and rest_after and rest_before[-1] == rest_after[-1]:
        rest_before, rest_after = rest_before[:-1], rest_after[:-1]
    return _one_line(rest_before), _one_line(rest_after)


def _one_line(lines: list[str]) -> str:
    return " ".join(" ".join(lines).split())
