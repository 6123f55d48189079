"""An object of a native class whose `__init__` was not called has nothing in it: each use of it is an error."""

import gc
import inspect

import cmrc._core
import pytest

NATIVE = sorted(
    (o for o in gc.get_objects() if inspect.isclass(o) and str(o.__module__).startswith(cmrc._core.__name__)),
    key=lambda o: (o.__module__, o.__qualname__),
)
CLASSES = [o for o in NATIVE if type(o).__name__ == "pybind11_type"]


def test_all_native_classes_are_tried():
    assert {"Simulation", "Network", "Processor", "Image", "Config"} <= {o.__name__ for o in CLASSES}


@pytest.mark.parametrize("native", CLASSES, ids=lambda o: f"{o.__module__}.{o.__qualname__}")
def test_each_use_is_an_error(native):
    made = native.__new__(native)
    for name, member in vars(native).items():
        if name.startswith("_") or isinstance(member, (staticmethod, type)):
            continue
        if isinstance(member, property):
            with pytest.raises((TypeError, RuntimeError)):
                getattr(made, name)
        elif callable(getattr(made, name)):
            with pytest.raises((TypeError, RuntimeError)):
                getattr(made, name)()


def test_the_message_names_the_cause():
    with pytest.raises(TypeError, match="an object whose __init__ was not called"):
        cmrc._core.c40.Processor.__new__(cmrc._core.c40.Processor).reset()
