"""An option that takes all paths that follow it, as a shell's ``*`` gives them."""

from __future__ import annotations

import click


class SeveralToVerify(click.Command):
    """
    A command whose ``--verify`` takes all words up to the next option.

    click gives an option one word; the next one would be an argument, without anybody noticing.
    """

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Repeat the option before each of its paths, which is how click takes several."""
        return super().parse_args(ctx, repeated(args, '--verify'))


def repeated(words: list[str], several: str) -> list[str]:
    """Return the words of a command line with an option before each word that follows it."""
    told: list[str] = []
    option = ''
    for index, word in enumerate(words):
        if word == '--':
            return [*told, *words[index:]]
        if word.startswith(f'{several}='):
            told.append(several)
            option, word = several, word.removeprefix(f'{several}=')
        elif word.startswith('-'):
            option = word
        elif option == several and told[-1] != several:
            told.append(several)
        told.append(word)
    return told
