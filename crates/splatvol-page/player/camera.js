// The camera: position, target, up and projection in the world, turned, shifted and brought nearer.

const plus = (a, b) => a.map((value, i) => value + b[i]);
const minus = (a, b) => a.map((value, i) => value - b[i]);
const times = (a, factor) => a.map((value) => value * factor);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => times(a, 1 / Math.hypot(...a));
const RADIANS = Math.PI / 180;

/** A vector turned about an axis of length 1, radians (Rodrigues). */
function turned(vector, axis, angle) {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return plus(plus(times(vector, c), times(cross(axis, vector), s)), times(axis, dot(axis, vector) * (1 - c)));
}

/** Directions of the picture in the world: to the right, up, and away from the eye. */
function axesOf(pose) {
  const away = unit(minus(pose.target, pose.position));
  const right = unit(cross(away, pose.up));
  return { right, up: cross(right, away), away };
}

/** The camera around its target: to its right, over it, and about the line of sight, degrees. */
function orbited(pose, azimuth, elevation, roll = 0) {
  const { right, up, away } = axesOf(pose);
  const turn = (vector) =>
    turned(turned(turned(vector, right, -elevation * RADIANS), up, azimuth * RADIANS), away, roll * RADIANS);
  return { ...pose, position: plus(pose.target, turn(minus(pose.position, pose.target))), up: turn(up) };
}

/** World length that fills the picture's height at the target. */
function heightAt(pose) {
  const { orthographic, perspective } = pose.projection;
  if (orthographic) return orthographic.height;
  const distance = Math.hypot(...minus(pose.target, pose.position));
  return 2 * distance * Math.tan(0.5 * perspective.fov_degrees * RADIANS);
}

/** The camera beside where it was: what is seen moves by so many picture heights, to the right and down. */
function panned(pose, x, y) {
  const { right, up } = axesOf(pose);
  const shift = times(plus(times(right, -x), times(up, y)), heightAt(pose));
  return { ...pose, position: plus(pose.position, shift), target: plus(pose.target, shift) };
}

/** The camera nearer to its target, or its parallel picture enlarged, by a factor. */
function zoomed(pose, factor) {
  const { orthographic } = pose.projection;
  if (orthographic) return { ...pose, projection: { orthographic: { height: orthographic.height / factor } } };
  return { ...pose, position: plus(pose.target, times(minus(pose.position, pose.target), 1 / factor)) };
}

/** Keys of the camera for a picture of another shape than the document's: a narrower one shows as much from side to side. */
function cameraKeys(pose, aspect, aspectOfDocument) {
  const { position, target, up, projection } = pose;
  const wider = Math.max(1, aspectOfDocument / aspect);
  if (projection.orthographic) return { position, target, up, orthographic: projection.orthographic.height * wider };
  const fov = projection.perspective.fov_degrees;
  if (wider === 1) return { position, target, up, fov };
  return { position, target, up, fov: (2 * Math.atan(Math.tan(0.5 * fov * RADIANS) * wider)) / RADIANS };
}
