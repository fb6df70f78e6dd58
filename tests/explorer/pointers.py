"""A mouse or a finger on the page of an arm."""

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
    """A pointer goes down at a place, moves, and is lifted."""
    along = [(x + dx * k / 5, y + dy * k / 5) for k in range(1, 6)]
    if pointer == "touch":
        steps = [("touchStart", [(x, y)]), *(("touchMove", [place]) for place in along), ("touchEnd", [])]
        for kind, places in steps:
            points = [{"x": a, "y": b} for a, b in places]
            window.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
        return
    window.execute_cdp_cmd("Input.dispatchMouseEvent", {"type": "mouseMoved", "x": x, "y": y})
    steps = [("mousePressed", (x, y)), *(("mouseMoved", place) for place in along), ("mouseReleased", along[-1])]
    for kind, (a, b) in steps:
        event = {"type": kind, "x": a, "y": b, "button": "left", "buttons": 1, "clickCount": 1}
        window.execute_cdp_cmd("Input.dispatchMouseEvent", event)
