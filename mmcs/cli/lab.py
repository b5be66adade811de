# SPDX-License-Identifier: Apache-2.0
"""`mmcs lab`, which the package of the lab sheets carries out."""

import click

from mmcs.labs import offered


class Lab(click.Command):
    """Loads the package when the command is used."""

    def make_context(self, info_name, args, parent=None, **extra) -> click.Context:
        command = offered("command").load()
        command.epilog = self.epilog
        return command.make_context(info_name, args, parent, **extra)


lab = Lab("lab", short_help="List the lab sheets; start one; check an answer, or those of a class.")
