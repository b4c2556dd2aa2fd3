"""Figures of the docs, drawn by the code that they describe."""

from pathlib import Path

from selfmotion.optimizers import OPTIMIZERS, AskTell
from selfmotion.plot import draw_flow, figure, flow_height, image_files


def write_flows(folder: Path):
    """Write the flow chart of every ask/tell optimizer; untouched files keep their time, so builds stay incremental."""
    folder.mkdir(exist_ok=True)
    for kind, optimizer in OPTIMIZERS.items():
        if not issubclass(optimizer, AskTell):
            continue
        with figure(height=flow_height(optimizer)) as (canvas, (axes,)):
            draw_flow(axes, optimizer)
            picture = image_files(f"flow_{kind}", canvas)[f"flow_{kind}.svg"]
        file = folder / f"flow_{kind}.svg"
        if not file.exists() or file.read_bytes() != picture:
            file.write_bytes(picture)
