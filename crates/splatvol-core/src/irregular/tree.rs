//! Tree for sums of all kernels at some of their centres. Its boxes enclose packets of kernels (Goldsmith and
//! Salmon, Automatic creation of object hierarchies for ray tracing, 1987); places are taken sixteen at a time,
//! neighbours together.
//!
//! Boxes are halved at the median of the centres, along the axis that is longest in widths of their kernels, so
//! that packets of flat kernels are flat, too. Only the packed kernels are kept between sums: finding terms again
//! takes no longer than reading them would.

use fearless_simd::Level;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::Sample;
use super::normalise::REACH_SQUARED;
use super::packets::{Block, Evaluated, LANES, Packet};

/// Packets near an average block of places beyond which sums are not worth their time. Meshes have 25 to 160; one point
/// far away makes kernels that reach all others, and so all pairs.
const MOST_PACKETS: usize = 512;
/// Blocks of places that stand for all when packets near them are counted.
const COUNTED_BLOCKS: usize = 64;

/// Number of kernels from which two threads share the halving.
const WORTH_A_THREAD: usize = 1 << 13;

/// A kernel during the halving of boxes.
#[derive(Debug, Clone, Copy)]
struct Centre {
    place: Vec3,
    width: Vec3,
    index: u32,
}

/// A box around all that some packets' kernels reach.
#[derive(Debug, Clone, Copy)]
struct Node {
    low: DVec3,
    high: DVec3,
    /// The second half, for a box of several packets; the first follows it.
    second: u32,
    /// The packet, for a box of one.
    packet: u32,
    is_leaf: bool,
}

impl Node {
    const EMPTY: Self = Self {
        low: DVec3::INFINITY,
        high: DVec3::NEG_INFINITY,
        second: 0,
        packet: 0,
        is_leaf: true,
    };
}

/// Tree of packets of kernels.
pub(super) struct Tree<'a> {
    samples: &'a [Sample],
    nodes: Vec<Node>,
    packets: Vec<Packet>,
    /// The samples of the packets' kernels, and their peaks for mass 1.
    order: Vec<u32>,
    peaks: Vec<f64>,
    level: Level,
}

impl<'a> Tree<'a> {
    /// Builds the tree from the samples that have a kernel.
    pub(super) fn new(samples: &'a [Sample]) -> Self {
        let centre = |(index, sample): (usize, &Sample)| {
            let v = &sample.covariance;
            let variances = DVec3::new(v.x_axis.x, v.y_axis.y, v.z_axis.z);
            Evaluated::new(sample).is_legal().then(|| Centre {
                place: sample.position.as_vec3(),
                width: variances.map(f64::sqrt).as_vec3(),
                index: index as u32,
            })
        };
        let mut centres: Vec<Centre> = samples.par_iter().enumerate().filter_map(centre).collect();
        let count = centres.len().div_ceil(LANES);
        let mut nodes = vec![Node::EMPTY; (2 * count).saturating_sub(1)];
        let mut packets = vec![Packet::around(DVec3::ZERO); count];
        if count > 0 {
            let part = Part {
                centres: &mut centres,
                nodes: &mut nodes,
                packets: &mut packets,
                first: [0, 0],
            };
            part.build(samples);
        }
        Self {
            samples,
            nodes,
            packets,
            peaks: centres
                .par_iter()
                .map(|centre| Evaluated::new(&samples[centre.index as usize]).peak)
                .collect(),
            order: centres.into_iter().map(|centre| centre.index).collect(),
            level: Level::new(),
        }
    }

    /// Samples with a kernel that are wanted, neighbours one after the other.
    pub(super) fn places(&self, is_wanted: impl Fn(usize) -> bool + Sync + Send) -> Vec<u32> {
        let own = self.order.par_iter().copied();
        own.filter(|&index| is_wanted(index as usize)).collect()
    }

    /// Whether sums take time in proportion to the number of kernels, rather than to its square.
    pub(super) fn is_affordable(&self) -> bool {
        let blocks = self.order.len().div_ceil(LANES);
        let mut near = Vec::new();
        let (mut counted, mut found) = (0, 0);
        for places in self
            .order
            .chunks(LANES)
            .step_by(blocks.div_ceil(COUNTED_BLOCKS).max(1))
        {
            self.packets_near(&self.block(places), &mut near);
            (counted, found) = (counted + 1, found + near.len());
        }
        found <= counted * MOST_PACKETS
    }

    fn block(&self, places: &[u32]) -> Block {
        Block::new(places.iter().map(|&place| self.samples[place as usize].position))
    }

    /// The sums of all kernels of these masses at the centres of samples.
    pub(super) fn sums(&self, places: &[u32], masses: &[f64]) -> Vec<f64> {
        let weights = self.weights(masses);
        let of_block = |near: &mut Vec<u32>, places: &[u32]| {
            let block = self.block(places);
            self.packets_near(&block, near);
            let packet = |&packet: &u32| (&self.packets[packet as usize], &weights[packet as usize]);
            let sums = block.sums(self.level, near.iter().map(packet));
            sums.into_iter().take(places.len()).map(f64::from)
        };
        let found: Vec<_> = places.par_chunks(LANES).map_init(Vec::new, of_block).collect();
        found.into_iter().flatten().collect()
    }

    /// Peaks of the kernels, packet by packet.
    fn weights(&self, masses: &[f64]) -> Vec<[f32; LANES]> {
        let packets = self.order.par_chunks(LANES).zip(self.peaks.par_chunks(LANES));
        let of_packet = |(order, peaks): (&[u32], &[f64])| {
            let mut weights = [0.0; LANES];
            for (weight, (&index, peak)) in weights.iter_mut().zip(order.iter().zip(peaks)) {
                *weight = (masses[index as usize] * peak) as f32;
            }
            weights
        };
        packets.map(of_packet).collect()
    }

    /// Number of kernels in the packets that are looked at for sums at places.
    #[cfg(test)]
    pub(super) fn work(&self, places: &[u32]) -> usize {
        let of_block = |places: &[u32]| {
            let mut near = Vec::new();
            self.packets_near(&self.block(places), &mut near);
            near.len() * LANES
        };
        places.chunks(LANES).map(of_block).sum()
    }

    /// Packets whose boxes overlap a block's.
    fn packets_near(&self, block: &Block, found: &mut Vec<u32>) {
        found.clear();
        // Median halves: no tree of 2^32 kernels is deeper.
        let mut stack = [0u32; 64];
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let index = stack[depth];
            let node = &self.nodes[index as usize];
            if block.high.cmplt(node.low).any() || block.low.cmpgt(node.high).any() {
                continue;
            }
            if node.is_leaf {
                found.push(node.packet);
            } else {
                stack[depth] = node.second;
                stack[depth + 1] = index + 1;
                depth += 2;
            }
        }
    }
}

/// Storage of a box and its halves, while they are built.
struct Part<'a> {
    centres: &'a mut [Centre],
    nodes: &'a mut [Node],
    packets: &'a mut [Packet],
    /// Numbers of the first node and packet.
    first: [usize; 2],
}

impl Part<'_> {
    fn build(self, samples: &[Sample]) {
        let Self {
            centres,
            nodes,
            packets,
            first: [node, packet],
        } = self;
        if packets.len() == 1 {
            let (low, high);
            (packets[0], low, high) = packed(centres, samples);
            nodes[0] = Node {
                low,
                high,
                packet: packet as u32,
                ..Node::EMPTY
            };
            return;
        }
        let half = packets.len() / 2;
        halve(centres, half * LANES);
        let is_large = centres.len() > WORTH_A_THREAD;
        let (own, halves) = nodes.split_at_mut(1);
        let (front_centres, back_centres) = centres.split_at_mut(half * LANES);
        let (front_nodes, back_nodes) = halves.split_at_mut(2 * half - 1);
        let (front_packets, back_packets) = packets.split_at_mut(half);
        let front = Part {
            centres: front_centres,
            nodes: front_nodes,
            packets: front_packets,
            first: [node + 1, packet],
        };
        let back = Part {
            centres: back_centres,
            nodes: back_nodes,
            packets: back_packets,
            first: [node + 2 * half, packet + half],
        };
        if is_large {
            rayon::join(|| front.build(samples), || back.build(samples));
        } else {
            front.build(samples);
            back.build(samples);
        }
        let [front, back] = [halves[0], halves[2 * half - 1]];
        own[0] = Node {
            low: front.low.min(back.low),
            high: front.high.max(back.high),
            second: (node + 2 * half) as u32,
            packet: 0,
            is_leaf: false,
        };
    }
}

/// Partitions the centres along the longest axis, with the first `middle` in front.
fn halve(centres: &mut [Centre], middle: usize) {
    let (mut low, mut high, mut width) = (Vec3::INFINITY, Vec3::NEG_INFINITY, Vec3::ZERO);
    for centre in &*centres {
        (low, high) = (low.min(centre.place), high.max(centre.place));
        width += centre.width;
    }
    let axis = ((high - low) / width).max_position();
    centres.select_nth_unstable_by(middle, |a, b| {
        let order = a.place[axis].total_cmp(&b.place[axis]);
        order.then(a.index.cmp(&b.index))
    });
}

/// A packet, and the bounding box of its kernels' reach. Centres are sorted, so that the result does not depend on
/// the halving.
fn packed(centres: &mut [Centre], samples: &[Sample]) -> (Packet, DVec3, DVec3) {
    centres.sort_unstable_by_key(|centre| centre.index);
    let mut packet = Packet::around(samples[centres[0].index as usize].position);
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for (lane, centre) in centres.iter().enumerate() {
        let sample = &samples[centre.index as usize];
        packet.set(lane, &Evaluated::new(sample), sample.position);
        let v = &sample.covariance;
        let variances = DVec3::new(v.x_axis.x, v.y_axis.y, v.z_axis.z);
        let reach = (variances * REACH_SQUARED).map(f64::sqrt);
        (low, high) = (
            low.min(sample.position - reach),
            high.max(sample.position + reach),
        );
    }
    (packet, low, high)
}
