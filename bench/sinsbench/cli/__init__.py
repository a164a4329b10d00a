"""The command line: results on standard output, progress on standard error.

Exit status: 0 done; 1 what was checked does not hold; 2 wrong usage or bad input, with one line that says what and
where.
"""

from __future__ import annotations

import os
import sys

from sinsbench.cli.commands import app


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
    import typer

    # The class of all complaints about usage: the base of the base of the one that typer exports.
    complaint: type[Exception] = typer.BadParameter.__mro__[2]
    try:
        result = app(arguments or ["--help"], prog_name="sinsbench", standalone_mode=False)
    except complaint as error:
        where = getattr(getattr(error, "ctx", None), "command_path", "sinsbench")
        return _refuse(f"{where}: {getattr(error, 'format_message', error.__str__)()}")
    except (KeyboardInterrupt, typer.Abort):
        print("sinsbench: interrupted; nothing half-written is left", file=sys.stderr)
        return 130
    except BrokenPipeError:
        # The reader went away, as `head` does: nothing more to say, also not at exit.
        sys.stderr.close()
        return 0
    except OSError as error:
        return _refuse(f"sinsbench: {error.filename or 'file'}: {error.strerror or error}")
    except ValueError as error:
        # An error that input can cause is a ValueError of ours; anything else is a defect and keeps its traceback.
        if type(error).__module__.partition(".")[0] not in ("sinsref", "sinsdata", "sinsbench"):
            raise
        return _refuse(f"sinsbench: {error}")
    return int(result or 0)


def _refuse(message: str) -> int:
    print(" ".join(message.split()), file=sys.stderr)
    return 2
