// Radix sort: keys with values by one digit of DIGIT_BITS, stably, by counts, their running sum and a scatter: no workgroup
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
const ROUNDS: u32 = 4u;
const DIGIT_BITS: u32 = 7u;
const DIGITS: u32 = 1u << DIGIT_BITS;
// Words of a bit for each lane.
const WORDS: u32 = LANES / 32u;

// Keys of a block with each digit.
var<workgroup> histogram: array<atomic<u32>, DIGITS>;
// Lanes whose key of a round has a digit, as bits; word by word, so that digits lie in different banks.
var<workgroup> marks: array<atomic<u32>, DIGITS * WORDS>;
// Place of the round's first key with each digit.
var<workgroup> places: array<u32, DIGITS>;

fn digit_of(key: u32) -> u32 {
    return (key >> digit.shift) & (DIGITS - 1u);
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
    if lane < DIGITS {
        atomicStore(&histogram[lane], 0u);
    }
    workgroupBarrier();
    for (var round = 0u; round < ROUNDS; round++) {
        let at = (block * ROUNDS + round) * LANES + lane;
        if at < digit.count {
            atomicAdd(&histogram[digit_of(keys[at])], 1u);
        }
    }
    workgroupBarrier();
    if lane < DIGITS && block < digit.blocks {
        counts[lane * digit.blocks + block] = atomicLoad(&histogram[lane]);
    }
}

// Marked lanes of a digit before a lane.
fn marked_before(d: u32, lane: u32) -> u32 {
    var count = 0u;
    for (var word = 0u; word < lane / 32u; word++) {
        count += countOneBits(atomicLoad(&marks[word * DIGITS + d]));
    }
    if lane % 32u != 0u {
        count += countOneBits(atomicLoad(&marks[lane / 32u * DIGITS + d]) & ((1u << (lane % 32u)) - 1u));
    }
    return count;
}

@compute @workgroup_size(256)
fn scatter(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let block = block_of(group, groups);
    if lane < DIGITS && block < digit.blocks {
        places[lane] = counts[lane * digit.blocks + block];
    }
    for (var round = 0u; round < ROUNDS; round++) {
        for (var word = lane; word < DIGITS * WORDS; word += LANES) {
            atomicStore(&marks[word], 0u);
        }
        workgroupBarrier();
        let at = (block * ROUNDS + round) * LANES + lane;
        var key = 0u;
        if at < digit.count {
            key = keys[at];
            atomicOr(&marks[lane / 32u * DIGITS + digit_of(key)], 1u << (lane % 32u));
        }
        workgroupBarrier();
        if at < digit.count {
            let d = digit_of(key);
            let place = places[d] + marked_before(d, lane);
            sorted_keys[place] = key;
            sorted_values[place] = values[at];
        }
        workgroupBarrier();
        if lane < DIGITS {
            places[lane] += marked_before(lane, LANES);
        }
        workgroupBarrier();
    }
}
