"""The report's table."""

from meshcore.report import Report


def test_the_table_shows_what_there_is():
    report = Report(
        "Relaxation",
        counts={"points": 1234567},
        quality={"smallest angle (degree)": 30.123456},
        iterations=7,
        residual=1.5e-9,
        converged=False,
        warnings=["stopped at the limit"],
        seconds=0.5,
    )
    assert report.rows() == [
        ("points", "1,234,567"),
        ("smallest angle (degree)", "30.12"),
        ("iterations", "7"),
        ("residual", "1.5e-09"),
        ("converged", "no"),
        ("seconds", "0.5"),
        ("warning", "stopped at the limit"),
    ]
    lines = str(report).splitlines()
    assert lines[0] == "Relaxation"
    assert len({line.index(text) for line, (_, text) in zip(lines[1:], report.rows(), strict=True)}) == 1


def test_an_empty_report_prints():
    assert str(Report()) == "report\n  seconds  0"
