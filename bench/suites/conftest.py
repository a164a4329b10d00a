"""What the stored results hold besides times: see `sinsbench.dashboard.recording`."""

from sinsbench.dashboard.recording import (
    calibration,
    pytest_benchmark_update_json,
    pytest_benchmark_update_machine_info,
    timed_beside,
)

__all__ = ["calibration", "pytest_benchmark_update_json", "pytest_benchmark_update_machine_info", "timed_beside"]
