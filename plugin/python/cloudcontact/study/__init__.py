"""Studies: a scene or a function, its parameters, and a row of results for each trial.

    from cloudcontact import study

    pegs = study.Study(
        "pegs",
        scene="peg.sdf",  # with ${clearance} and ${offset} in it
        parameters={
            "clearance": study.Range(2e-4, 1e-3, 25),
            "offset": study.Range(0, 1.2e-3, 40),
            "seconds": 0.2,
        },
        success="peg_z < 0.006",
    )
    results = pegs.run("pegs.sqlite")  # on="dask:ADDRESS", on="mpi" or any executor
    print(study.summarize(results))
    study.plot_success(results, file="success.png")

A study that is run again goes on where it stopped. docs/studies.md is the guide, cloudcontact-study the
command.
"""

from .design import Range
from .errors import StudyError, StudyStopped
from .results import Results
from .study import Study
from .study_file import load
from .study_plots import plot_success, plot_wrenches
from .summary import Summary, summarize

__all__ = [
    "Range",
    "Results",
    "Study",
    "StudyError",
    "StudyStopped",
    "Summary",
    "load",
    "plot_success",
    "plot_wrenches",
    "summarize",
]
