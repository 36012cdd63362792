// Clips: exact parts of a pixel's ray between two planes that clips leave visible; `splatvol_cpu::sheets::cut`.
//
// Along a ray a plane's distance is linear in depth, so a convex body is one interval, from the last entered plane to the
// first left one.

// Bodies: their first plane, the end of their planes, and whether their inside is kept. Then planes: normal and offset in
// camera space, `normal . p + offset` positive inside. Then isosurfaces: value and extinction; linear colour.
@group(0) @binding(9) var<storage, read> effects: array<vec4<f32>>;

// Largest distance that rounding may move a face in front of its interval's start.
const ROUNDING: f32 = 1e-3;
const NEVER: f32 = 3e38;

// A ray between two planes: its start, and the step to its end; camera space.
struct RaySegment {
    start: vec3<f32>,
    step: vec3<f32>,
}

// Entry and exit of a ray through a body, with the planes' normals; empty if it enters after it leaves.
struct Passage {
    enter: f32,
    leave: f32,
    entered: vec3<f32>,
    left: vec3<f32>,
    keeps_inside: bool,
}

// A visible part of an interval, 0 to 1 from plane to plane; empty where it ends before it begins.
struct Range {
    start: f32,
    end: f32,
    // Normal of the cut at which it begins, if any; it points out of the visible part.
    face: vec3<f32>,
    has_face: bool,
}

fn passage(body: u32, ray: RaySegment) -> Passage {
    let own = effects[body];
    var p = Passage(-NEVER, NEVER, vec3(0.0), vec3(0.0), own.z != 0.0);
    for (var i = u32(own.x); i < u32(own.y); i++) {
        let plane = effects[i];
        let start = dot(plane.xyz, ray.start) + plane.w;
        let slope = dot(plane.xyz, ray.step);
        if slope > 0.0 && -start / slope > p.enter {
            p.enter = -start / slope;
            p.entered = plane.xyz;
        } else if slope < 0.0 && start / -slope < p.leave {
            p.leave = start / -slope;
            p.left = plane.xyz;
        } else if slope == 0.0 && start < 0.0 {
            p.leave = -NEVER;
        }
    }
    return p;
}

// Moves the start of a range to a face, if that is later.
fn begin_at(range: Range, at: f32, normal: vec3<f32>) -> Range {
    if at >= range.start - ROUNDING {
        return Range(max(range.start, at), range.end, normal, true);
    }
    return range;
}

// The first visible part of an interval from a place on.
fn next_range(ray: RaySegment, start: f32) -> Range {
    var range = Range(start, 1.0, vec3(0.0), false);
    // What bodies hide begins and ends once, so each moves the start once at most.
    for (var round = 0u; round <= frame.bodies; round++) {
        let before = range.start;
        range.end = 1.0;
        for (var body = 0u; body < frame.bodies; body++) {
            let p = passage(body, ray);
            if p.keeps_inside {
                range = begin_at(range, p.enter, -p.entered);
                range.end = min(range.end, p.leave);
            } else if p.enter < p.leave {
                if p.enter <= range.start {
                    range = begin_at(range, p.leave, p.left);
                } else {
                    range.end = min(range.end, p.enter);
                }
            }
        }
        if range.start == before {
            break;
        }
    }
    return range;
}

// Whether clips leave a place.
fn is_left(ray: RaySegment, u: f32) -> bool {
    for (var body = 0u; body < frame.bodies; body++) {
        let p = passage(body, ray);
        if (p.enter <= u && u < p.leave) != p.keeps_inside {
            return false;
        }
    }
    return true;
}

// Whether clips leave a point, camera space.
fn is_kept(point: vec3<f32>) -> bool {
    for (var body = 0u; body < frame.bodies; body++) {
        let own = effects[body];
        var inside = true;
        for (var i = u32(own.x); i < u32(own.y); i++) {
            inside = inside && dot(effects[i].xyz, point) + effects[i].w >= 0.0;
        }
        if inside != (own.z != 0.0) {
            return false;
        }
    }
    return true;
}
