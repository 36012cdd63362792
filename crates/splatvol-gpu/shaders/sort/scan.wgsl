// Scan: running sums of numbers, each without its own, by blocks of 1,024; the sums of blocks go to the next level.

struct Scan {
    count: u32,
    unused_0: u32,
    unused_1: u32,
    unused_2: u32,
}

@group(0) @binding(0) var<uniform> scan: Scan;
@group(0) @binding(1) var<storage, read_write> numbers: array<u32>;
@group(0) @binding(2) var<storage, read_write> blocks: array<u32>;

const LANES: u32 = 256u;
const PER_LANE: u32 = 4u;

var<workgroup> sums: array<u32, LANES>;

@compute @workgroup_size(256)
fn scan_blocks(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let block = group.y * groups.x + group.x;
    let first = (block * LANES + lane) * PER_LANE;
    var own = 0u;
    for (var i = first; i < min(first + PER_LANE, scan.count); i++) {
        own += numbers[i];
    }
    sums[lane] = own;
    workgroupBarrier();
    for (var step = 1u; step < LANES; step <<= 1u) {
        var before = 0u;
        if lane >= step {
            before = sums[lane - step];
        }
        workgroupBarrier();
        sums[lane] += before;
        workgroupBarrier();
    }
    var running = sums[lane] - own;
    for (var i = first; i < min(first + PER_LANE, scan.count); i++) {
        let number = numbers[i];
        numbers[i] = running;
        running += number;
    }
    if lane == LANES - 1u && block * LANES * PER_LANE < scan.count {
        blocks[block] = sums[lane];
    }
}

@compute @workgroup_size(256)
fn add_blocks(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let block = group.y * groups.x + group.x;
    let first = (block * LANES + lane) * PER_LANE;
    for (var i = first; i < min(first + PER_LANE, scan.count); i++) {
        numbers[i] += blocks[block];
    }
}
