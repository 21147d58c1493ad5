"""Cut the face mesh with attention to the lips out of MediaPipe's file, in two parts.

Between the parts lie operations that are MediaPipe's own, which OpenCV does not have. What they do
is in `abs_engine/tracking/detection/attention_mesh.py`; where they lay the lips is written to a
JSON file.
Weights and operations of the parts are unchanged; what only the eyes need is left out.

`parts` needs ``pip install ai-edge-litert==2.3.0 flatbuffers==25.12.19``, for the file format.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

MESH, FEATURES, PRESENCE = "output_mesh", "p_re_lu_3", "conv_faceflag"
LIPS, ABOUT_LIPS = "conv_lips", "transform_tensor_bilinear_v2"
PLACING = b"Landmarks2TransformMatrix"  # the first of these places the lips


def parts(network: bytes) -> dict[str, bytes]:
    """The files that the network is cut into, by name."""
    return {
        "face_mesh.tflite": _cut(network, ["input_1"], [MESH, FEATURES, PRESENCE]),
        "face_lips.tflite": _cut(network, [ABOUT_LIPS], [LIPS]),
        "face_lips.json": _placing(network),
    }


def _opened(network: bytes) -> Any:
    from ai_edge_litert import schema_py_generated as schema

    return schema.ModelT.InitFromObj(schema.Model.GetRootAs(network, 0))


def _placing(network: bytes) -> bytes:
    """Landmarks of the lips, their ends, and how far around them the second part looks."""
    from flatbuffers import flexbuffers

    model = _opened(network)
    first = next(
        op
        for op in model.subgraphs[0].operators
        if model.operatorCodes[op.opcodeIndex].customCode == PLACING
    )
    known = flexbuffers.Loads(bytes(bytearray(first.customOptions)))
    # MediaPipe's left is the picture's: the subject's right corner of the mouth
    ends = [known["left_rotation_idx"], known["right_rotation_idx"]]
    if known["scale_x"] != known["scale_y"] or known["target_rotation_radians"] != 0:
        raise ValueError("the lips are placed in another way")
    placing = {"landmarks": known["subset_idxs"], "ends": ends, "around": known["scale_x"]}
    return (json.dumps(placing, separators=(",", ":")) + "\n").encode()


def _cut(network: bytes, inputs: Sequence[str], outputs: Sequence[str]) -> bytes:
    """The part of a network between these tensors."""
    import flatbuffers

    model = _opened(network)
    graph = model.subgraphs[0]
    at = {tensor.name.decode(): k for k, tensor in enumerate(graph.tensors)}
    first, last = [at[name] for name in inputs], [at[name] for name in outputs]
    graph.operators = _between(graph.operators, first, last)
    named = [int(t) for op in graph.operators for t in (*op.inputs, *op.outputs)]
    tensors = sorted({*(t for t in named if t >= 0), *first, *last})
    place = {-1: -1, **{t: k for k, t in enumerate(tensors)}}
    for op in graph.operators:
        op.inputs, op.outputs = ([place[int(t)] for t in ends] for ends in (op.inputs, op.outputs))
    graph.tensors = [graph.tensors[t] for t in tensors]
    graph.inputs, graph.outputs = ([place[t] for t in ends] for ends in (first, last))
    _drop_unused(model)
    packed = flatbuffers.Builder(1 << 20)
    packed.Finish(model.Pack(packed), b"TFL3")
    return bytes(packed.Output())


def _between(operators: Sequence[Any], first: Sequence[int], last: Sequence[int]) -> list[Any]:
    """The operators that lead from the first tensors to the last."""
    maker = {int(t): k for k, op in enumerate(operators) for t in op.outputs}
    kept, found, open_ends = set(), set(first), list(last)
    while open_ends:
        tensor = open_ends.pop()
        if tensor in found:
            continue
        found.add(tensor)
        if tensor in maker:
            kept.add(maker[tensor])
            open_ends += [int(t) for t in operators[maker[tensor]].inputs if t >= 0]
    return [operators[k] for k in sorted(kept)]


def _drop_unused(model: Any) -> None:
    """Leave out buffers and codes of operators that nothing of the network names any more."""
    graph = model.subgraphs[0]
    buffers = list(dict.fromkeys([0, *(t.buffer for t in graph.tensors)]))
    for tensor in graph.tensors:
        tensor.buffer = buffers.index(tensor.buffer)
    model.buffers = [model.buffers[k] for k in buffers]
    codes = list(dict.fromkeys(op.opcodeIndex for op in graph.operators))
    for op in graph.operators:
        op.opcodeIndex = codes.index(op.opcodeIndex)
    model.operatorCodes = [model.operatorCodes[k] for k in codes]
    model.metadata = model.metadataBuffer = model.signatureDefs = None
