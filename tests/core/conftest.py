"""Settings of the core suite."""

from __future__ import annotations

from hypothesis import HealthCheck, settings

# Tests never time; a first call compiles for seconds. Derandomised, so that a failure is everyone's failure.
settings.register_profile(
    "meshcore",
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
settings.load_profile("meshcore")
