"""The notebooks run from top to bottom, in a kernel of their own, on the FMUs that `flexsat build` leaves."""

from pathlib import Path

import pytest

nbclient = pytest.importorskip("nbclient", reason="notebooks are executed with nbclient, of the dependency group dev")
nbformat = pytest.importorskip("nbformat", reason="notebooks are read with nbformat, of the dependency group dev")
EXAMPLES = Path(__file__).parents[2] / "examples"


def executed(name, delivered, folder):
    """Return the notebook after its run, with the FMUs and the examples where a user has them."""
    (folder / "fmus").symlink_to(delivered)
    (folder / "examples").symlink_to(EXAMPLES)
    notebook = nbformat.read(EXAMPLES / f"{name}.ipynb", as_version=4)
    nbclient.NotebookClient(notebook, timeout=900, resources={"metadata": {"path": str(folder)}}).execute()
    return notebook


def printed(notebook):
    """Return what the cells printed."""
    return "".join(output.get("text", "") for cell in notebook.cells for output in cell.get("outputs", ()))


@pytest.mark.filterwarnings("default")  # of the client's own loop of events
def test_the_paper_in_fifteen_cells(delivered, tmp_path):
    notebook = executed("the_paper", delivered, tmp_path)

    assert len(notebook.cells) == 15
    text = printed(notebook)
    assert "limit cycle" in text
    assert "largest wheel torque 0.80 N.m" in text
    figures = [
        output for cell in notebook.cells for output in cell.get("outputs", ()) if "image/png" in output.get("data", {})
    ]
    assert len(figures) == 4


@pytest.mark.filterwarnings("default")
def test_a_vendors_controller_from_fmu_to_margin(delivered, tmp_path):
    text = printed(executed("vendor_controller", delivered, tmp_path))

    assert 'write direction = "inertial-from-body"' in text
    assert '\ndirection = "inertial-from-body"' in text  # the adapter, corrected
    assert "measured: z" in text


@pytest.mark.parametrize("name", ["the_paper", "vendor_controller"])
def test_a_notebook_is_stored_without_outputs(name):
    """Outputs would be of some earlier version, and large."""
    notebook = nbformat.read(EXAMPLES / f"{name}.ipynb", as_version=4)

    assert not [cell for cell in notebook.cells if cell.get("outputs") or cell.get("execution_count")]
