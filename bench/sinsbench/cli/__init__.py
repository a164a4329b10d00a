"""The command line: results on standard output, progress on standard error.

Exit status: 0 done; 1 what was checked does not hold; 2 wrong usage or bad input, with one line that says what and
where.
"""

from __future__ import annotations

import os
import sys

_INTERRUPTED = 130


def main() -> None:
    """Run the command line and leave with its exit status."""
    sys.exit(run(sys.argv[1:]))


def run(arguments: list[str]) -> int:
    """Run the command line with arguments and return its exit status.

    Parameters
    ----------
    arguments : list of str
        What stands behind ``sinsbench``.
    """
    # Matrices here are 6 x 6: a library that starts threads for them spends its time on waking these.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    try:
        return _run(arguments)
    except KeyboardInterrupt:
        return _interrupted()
    except BrokenPipeError:
        return _reader_gone()
    except UnicodeEncodeError as error:
        return _refuse(f"sinsbench: {error.object!r} is not UTF-8")
    except OSError as error:
        # Typer turns a closed pipe into an exit of its own; what remains has a file and a reason.
        return _refuse(f"sinsbench: {error.filename or 'file'}: {error.strerror or error}")
    except (ValueError, RuntimeError, ArithmeticError) as error:
        # An error that input or machine can cause is one of ours; anything else is a defect and keeps its traceback.
        if type(error).__module__.partition(".")[0] not in ("sinsref", "sinsdata", "sinsbench"):
            raise
        return _refuse(f"sinsbench: {error}")


def _run(arguments: list[str]) -> int:
    import typer

    from sinsbench.cli.commands import app

    # The class of all complaints about usage: the base of the base of the one that typer exports.
    complaint: type[Exception] = typer.BadParameter.__mro__[2]
    try:
        status = int(app(arguments or ["--help"], prog_name="sinsbench", standalone_mode=False) or 0)
    except complaint as error:
        where = getattr(getattr(error, "ctx", None), "command_path", "sinsbench")
        return _refuse(f"{where}: {getattr(error, 'format_message', error.__str__)()}")
    except typer.Abort:
        return _interrupted()
    except SystemExit as error:
        # Typer's answer to a closed pipe; commands of ours end with typer.Exit.
        return _reader_gone() if isinstance(error.__context__, BrokenPipeError) else int(error.code or 0)
    # Some versions of typer answer an interrupt with this status and no word.
    return _interrupted() if status == _INTERRUPTED else status


def _interrupted() -> int:
    print(
        "sinsbench: interrupted; no file is half-written, and `generate` goes on where it stopped",
        file=sys.stderr,
    )
    return _INTERRUPTED


def _reader_gone() -> int:
    """Leave without a word where the reader of the output went away, as `head` does."""
    # What is still buffered goes nowhere, also at exit.
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return 0


def _refuse(message: str) -> int:
    print(" ".join(message.split()), file=sys.stderr)
    return 2
