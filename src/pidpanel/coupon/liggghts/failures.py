"""Failures of a run: one class for each reason; the text has the place."""


class SolverFailure(RuntimeError):
    """A failed LIGGGHTS run; the class is the reason, the text has the place."""


class SolverMissing(SolverFailure):
    """LIGGGHTS is not installed, or is another version."""


class DeckRefused(SolverFailure):
    """A deck of the user's own that is not trusted."""


class RunStopped(SolverFailure):
    """The process ended, or was ended, before its last step."""


class RunHung(SolverFailure):
    """The process went on without saying anything, far longer than its steps take."""


class LogTruncated(SolverFailure):
    """Rows, columns or marks are missing, doubled or cut."""


class FileDamaged(SolverFailure):
    """A file is missing, or is not the one that was left here."""


class Unphysical(SolverFailure):
    """A row that no motion of the particles can have."""


class NotFinite(SolverFailure):
    """A number in the output is NaN, infinite or unreadable."""


class ParticlesLost(SolverFailure):
    """Particles left the cells or were never there."""


class UnderFilled(SolverFailure):
    """The poured bed does not reach the lid, so the fill fraction has no meaning."""


class NotSteady(SolverFailure):
    """The transient did not end within max_cycles, or the mean drifts after it."""


class EnergyNotClosed(SolverFailure):
    """The loss of the contacts differs from the work of the shaker."""


class LossesApart(SolverFailure):
    """The loss of the contacts in the window differs from that of the rows by a large factor."""


# Failures that the same inputs give again; any other is tried again in the next call.
BY_INPUTS = frozenset(
    kind.__name__ for kind in (Unphysical, NotFinite, ParticlesLost, UnderFilled, NotSteady)
)


class RunFailed(SolverFailure):
    """A step that ended with another failure, whose name is its `status`."""

    def __init__(self, status: str, message: str) -> None:
        super().__init__(message)
        self.status = status


class RecordUnreadable(SolverFailure):
    """A JSON file of a packing, a bed or a run is cut, or has other keys than are expected."""
