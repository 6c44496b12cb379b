"""YAML from a text, with one exception for all that PyYAML raises, and without what contains itself."""

import math

import yaml

_LARGEST_BITS = 1023  # of a whole number that a float can hold


class NotYaml(ValueError):
    """What is wrong, in one line; ``at`` is (line, column), counted from 1, where known."""

    def __init__(self, problem: str, at: tuple[int, int] | None = None) -> None:
        super().__init__(problem)
        self.at = at


class _Loader(yaml.SafeLoader):
    def construct_object(self, node: yaml.Node, deep: bool = False) -> object:
        try:
            found = super().construct_object(node, deep)
            if isinstance(found, int) and found.bit_length() > _LARGEST_BITS:
                return math.inf  # as 1e999 is
            return found
        except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
            # PyYAML lets through what Python's own types say of a date 2026-13-45, or of !!int x.
            reason = str(error) if isinstance(error, ValueError) else f'not what {node.tag} is written like'
            problem = f"'{node.value}': {reason}" if isinstance(node, yaml.ScalarNode) else reason
            raise yaml.MarkedYAMLError(problem=' '.join(problem.split()), problem_mark=node.start_mark) from None

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[object, object]:
        # PyYAML takes the last of two equal keys: of two limits, one that nobody may have meant.
        seen = set[str]()
        for key in (key for key, _ in node.value if isinstance(key, yaml.ScalarNode)):
            if key.value in seen:
                raise yaml.MarkedYAMLError(problem=f"'{key.value}' stands there twice", problem_mark=key.start_mark)
            seen.add(key.value)
        return super().construct_mapping(node, deep)


def parse(text: str) -> object:
    """What a text says in YAML 1.1, without a key that stands twice.

    Raises:
        NotYaml: it says nothing, or something without an end: an alias inside what it names.
    """
    try:
        content: object = yaml.load(text, _Loader)
        if _contains_itself(content, set(), set()):
            raise NotYaml('an alias (*) stands inside what it names')
    except yaml.YAMLError as error:
        mark = getattr(error, 'problem_mark', None)
        problem = getattr(error, 'problem', None) or getattr(error, 'reason', None) or 'no YAML'
        if "'\\t'" in problem:
            problem = 'a tab, which YAML does not take as an indent: put spaces'
        raise NotYaml(problem, (mark.line + 1, mark.column + 1) if mark else None) from None
    except RecursionError:
        raise NotYaml('nested too deeply') from None
    return content


def quoted(text: str) -> str:
    """A text as YAML, in double quotes and in one line: whatever stands in it, it is read back as it is."""
    return yaml.safe_dump(text, default_style='"', allow_unicode=True, width=math.inf).rstrip('\n')


def _contains_itself(node: object, above: set[int], done: set[int]) -> bool:
    """Is a list or mapping among those that it stands in? Each is looked at once, however often it is named."""
    if not isinstance(node, (dict, list, tuple)) or id(node) in done:
        return False
    if id(node) in above:
        return True
    above.add(id(node))
    for below in node.values() if isinstance(node, dict) else node:
        if _contains_itself(below, above, done):
            return True
    above.remove(id(node))
    done.add(id(node))
    return False
