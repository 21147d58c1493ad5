"""Ground truth of filmed clips: the layout of a dataset, its encodings, and the only reader of it.

``README.md`` of a dataset (`card`) documents the layout.
"""

from abs_engine.dataset.arrays import write_chunk, write_points, write_truth
from abs_engine.dataset.camera_file import camera_json, load_camera, load_placed_camera
from abs_engine.dataset.clip import Clip, Phoneme, load_clip
from abs_engine.dataset.codec import DEPTH_STEP, LABELS
from abs_engine.dataset.dataset import ClipEntry, Dataset, dataset_record, load_dataset, load_truth
from abs_engine.dataset.sums import SUMS, check_sums, write_sums
from abs_engine.dataset.view import Truth

__all__ = [
    "DEPTH_STEP", "LABELS", "SUMS", "Clip", "ClipEntry", "Dataset",
    "Phoneme", "Truth", "camera_json", "check_sums", "dataset_record",
    "load_camera", "load_clip", "load_dataset", "load_placed_camera", "load_truth", "write_chunk",
    "write_points", "write_sums", "write_truth",
]  # fmt: skip
