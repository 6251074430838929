"""Print a script that completes commands, options and files of pidpanel in a shell.

In ~/.bashrc: eval "$(pidpanel completion bash)". For zsh, in a folder of $fpath:
pidpanel completion zsh > _pidpanel
"""

import argparse


def call(args: argparse.Namespace) -> int:
    import shtab

    from pidpanel.cli.parser import parser

    print(shtab.complete(parser(), args.shell))
    return 0
