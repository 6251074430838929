"""Print the JSON schema (2020-12) of a study, for editors that complete and check YAML."""

import argparse

HELP = "Print the JSON schema of a study."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add no arguments: there is one schema."""


def call(args: argparse.Namespace) -> int:
    from pidpanel.study.json_schema import schema_text

    print(schema_text(), end="")
    return 0
