// Radix sort: keys with values by one digit of four bits, stably, by counts, their running sum and a scatter: no workgroup
// waits for another one (Merrill and Grimshaw 2011 sum up what others do; WebGPU does not promise forward progress).

struct Digit {
    count: u32,
    shift: u32,
    // Workgroups: keys by 1,024.
    blocks: u32,
    unused: u32,
}

@group(0) @binding(0) var<uniform> digit: Digit;
@group(0) @binding(1) var<storage, read> keys: array<u32>;
@group(0) @binding(2) var<storage, read> values: array<u32>;
// By digit, then block: how often it occurs; then how many keys are before.
@group(0) @binding(3) var<storage, read_write> counts: array<u32>;
@group(0) @binding(4) var<storage, read_write> sorted_keys: array<u32>;
@group(0) @binding(5) var<storage, read_write> sorted_values: array<u32>;

const LANES: u32 = 256u;
const PER_LANE: u32 = 4u;
// Sixteen counters of 16 bits.
const WORDS: u32 = 8u;

var<workgroup> sums: array<array<u32, WORDS>, LANES>;

fn digit_of(key: u32) -> u32 {
    return (key >> digit.shift) & 15u;
}

// Counters of one lane's keys.
fn counters(first: u32) -> array<u32, WORDS> {
    var own: array<u32, WORDS>;
    for (var i = first; i < min(first + PER_LANE, digit.count); i++) {
        let d = digit_of(keys[i]);
        own[d >> 1u] += 1u << (16u * (d & 1u));
    }
    return own;
}

// Makes `sums` the sums of counters up to each lane.
fn add_up(lane: u32, own: array<u32, WORDS>) {
    sums[lane] = own;
    workgroupBarrier();
    for (var step = 1u; step < LANES; step <<= 1u) {
        var before: array<u32, WORDS>;
        if lane >= step {
            before = sums[lane - step];
        }
        workgroupBarrier();
        for (var word = 0u; word < WORDS; word++) {
            sums[lane][word] += before[word];
        }
        workgroupBarrier();
    }
}

fn counter(words: array<u32, WORDS>, d: u32) -> u32 {
    var copy = words;
    return (copy[d >> 1u] >> (16u * (d & 1u))) & 0xffffu;
}

fn block_of(group: vec3<u32>, groups: vec3<u32>) -> u32 {
    return group.y * groups.x + group.x;
}

@compute @workgroup_size(256)
fn count(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let block = block_of(group, groups);
    add_up(lane, counters((block * LANES + lane) * PER_LANE));
    if lane < 16u && block < digit.blocks {
        counts[lane * digit.blocks + block] = counter(sums[LANES - 1u], lane);
    }
}

@compute @workgroup_size(256)
fn scatter(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let block = block_of(group, groups);
    let first = (block * LANES + lane) * PER_LANE;
    let own = counters(first);
    add_up(lane, own);
    // Keys of the block before this lane's.
    var before: array<u32, WORDS>;
    for (var word = 0u; word < WORDS; word++) {
        before[word] = sums[lane][word] - own[word];
    }
    for (var i = first; i < min(first + PER_LANE, digit.count); i++) {
        let key = keys[i];
        let d = digit_of(key);
        let place = counts[d * digit.blocks + block] + counter(before, d);
        before[d >> 1u] += 1u << (16u * (d & 1u));
        sorted_keys[place] = key;
        sorted_values[place] = values[i];
    }
}
