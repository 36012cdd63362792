"""Runs checks and counts how they end. Nothing that did not run counts as passed."""

from dataclasses import dataclass, field

from known_faults import KNOWN_FAULTS


class Skipped(Exception):
    """Raised by a check that cannot run here; says why."""


@dataclass
class Outcomes:
    """Labels of checks by how they ended."""

    passed: list = field(default_factory=list)
    failed: list = field(default_factory=list)
    skipped: list = field(default_factory=list)
    faults: list = field(default_factory=list)

    def run(self, label, check):
        """Runs one check; a failure is printed at once."""
        fault = KNOWN_FAULTS.get(label)
        try:
            check()
        except Skipped as skipped:
            self.skipped.append(f"{label}: {skipped}")
        except Exception as error:  # Whatever a reader raises, the files do not agree.
            # Only the fault that is known is excused.
            if fault is None or fault.says not in str(error):
                print(f"FAILED {label}: {type(error).__name__}: {error}")
                self.failed.append(label)
            else:
                self.faults.append(f"{label}: {fault.reason}")
        else:
            if fault is None:
                self.passed.append(label)
            else:
                print(f"FAILED {label}: it passes now; take it out of known_faults.py")
                self.failed.append(label)

    def report(self):
        """Prints counts, and names everything that did not pass."""
        for what, labels in [("skipped", self.skipped), ("known fault", self.faults)]:
            for label in labels:
                print(f"{what}: {label}")
        ran = len(self.passed) + len(self.failed)
        print(
            f"independent readers: {len(self.passed)} of {ran} checks passed,"
            f" {len(self.skipped)} skipped, {len(self.faults)} known faults"
        )
