"""A mouse, a finger and keys on the page of an arm."""

ARROW = """const [axis] = arguments, e = lwrExplorer, { camera, canvas } = e.stage.viewer, { handle } = e.flangeDrag;
const pane = canvas.getBoundingClientRect(); camera.updateMatrixWorld(); handle.updateWorldMatrix(true, false);
const far = handle.getWorldPosition(new THREE.Vector3()).distanceTo(camera.position);
const long = 0.061 * far * Math.min(1.9 * Math.tan((Math.PI * camera.fov) / 360), 7), tip = new THREE.Vector3();
const at = handle.localToWorld(tip.setComponent(axis, long)).project(camera);
return [pane.left + ((at.x + 1) * pane.width) / 2, pane.top + ((1 - at.y) * pane.height) / 2];"""


def arrow(window, axis):
    """Where in the window the arrow of an axis (0, 1, 2) of the flange's handle is [px]."""
    return window.execute_script(ARROW, axis)


def pulled(window, pointer, x, y, dx, dy):
    """A pointer, "mouse" or "touch", goes down at a place, moves, and is lifted."""
    move = touch if pointer == "touch" else mouse
    move(window, (x, y), *((x + dx * k / 5, y + dy * k / 5) for k in range(1, 6)))


def touch(window, *places):
    """A finger goes down at the first place [px], along the others, and up."""
    kinds = ["touchStart", *["touchMove"] * (len(places) - 1)]
    for kind, (x, y) in zip(kinds, places, strict=True):
        window.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [{"x": x, "y": y}]})
    window.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})


def mouse(window, *places):
    """The mouse comes to the first place [px], its button goes down, along the others, and up."""
    window.execute_cdp_cmd("Input.dispatchMouseEvent", {"type": "mouseMoved", "x": places[0][0], "y": places[0][1]})
    steps = [
        ("mousePressed", places[0]),
        *(("mouseMoved", place) for place in places[1:]),
        ("mouseReleased", places[-1]),
    ]
    for kind, (x, y) in steps:
        event = {"type": kind, "x": x, "y": y, "button": "left", "buttons": 1, "clickCount": 1}
        window.execute_cdp_cmd("Input.dispatchMouseEvent", event)


def press(window, key, shift=False):
    """A key of the keyboard."""
    code = {"Tab": 9, "Enter": 13}.get(key, 0)
    event = {"key": key, "code": key, "modifiers": 8 * shift, "windowsVirtualKeyCode": code}
    window.execute_cdp_cmd("Input.dispatchKeyEvent", {"type": "rawKeyDown", **event})
    window.execute_cdp_cmd("Input.dispatchKeyEvent", {"type": "keyUp", **event})
