"""Print the JSON schema (2020-12) of a study, for editors that complete and check YAML."""

import argparse


def call(args: argparse.Namespace) -> int:
    from pidpanel.study.json_schema import schema_text

    print(schema_text(), end="")
    return 0
