//! Frame statistics: seconds per stage and counts, for `--stats` and for tests of the pipeline's work.

use serde::Serialize;

/// Wall-clock seconds per stage. Stages that run inside tiles are summed over threads.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct StageSeconds {
    /// Samples to kernel coefficients; zero where an earlier frame's are still right.
    pub prefilter: f64,
    /// Transfer-function tables, per-brick visibility.
    pub classify: f64,
    /// Bricks projected and sorted into tile lists.
    pub bin: f64,
    /// Voxels found and brought into camera space, summed over threads (part of `splat` where gradients are analytic).
    pub activate: f64,
    /// Voxels to sheets, summed over threads.
    pub splat: f64,
    /// Finished sheets taken out of the ring, summed over threads (none where gradients are analytic).
    pub take: f64,
    /// Sheets classified, lit and composited, summed over threads.
    pub shade: f64,
    /// The whole tile loop, wall clock.
    pub tiles: f64,
    /// The whole frame, wall clock.
    pub total: f64,
}

impl StageSeconds {
    /// Sums of both, stage by stage.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            prefilter: self.prefilter + other.prefilter,
            classify: self.classify + other.classify,
            bin: self.bin + other.bin,
            activate: self.activate + other.activate,
            splat: self.splat + other.splat,
            take: self.take + other.take,
            shade: self.shade + other.shade,
            tiles: self.tiles + other.tiles,
            total: self.total + other.total,
        }
    }
}

impl ChunkStatistics {
    /// Of two pictures: sums, and the larger of the levels' chunks, of the reads of one, and of the bytes at a time.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            all: self.all.max(other.all),
            touched: self.touched + other.touched,
            reads: self.reads + other.reads,
            most_reads: self.most_reads.max(other.most_reads),
            bytes: self.bytes + other.bytes,
            holes: self.holes + other.holes,
            planned_bytes: self.planned_bytes.max(other.planned_bytes),
        }
    }
}

/// What a pass took on a device.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct PassSeconds {
    /// Name of the pass.
    pub pass: String,
    /// Seconds, of all its dispatches.
    pub seconds: f64,
}

/// Bytes that a renderer holds between frames, by purpose.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct MemoryUse {
    /// Volumes of the scene: samples, and the engines' derived data.
    pub volumes: usize,
    /// Volumes of earlier scenes: samples and derived data.
    pub spare_volumes: usize,
    /// Clouds of points, Gaussians and samples of meshes.
    pub clouds: usize,
    /// Memory of the tiles.
    pub tiles: usize,
    /// Memory of a device: coefficients and pictures.
    pub device: usize,
}

/// Chunks of volumes that are larger than memory, read for a picture.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct ChunkStatistics {
    /// Chunks of the levels that were drawn.
    pub all: u64,
    /// Different chunks that were read. All others are invisible, hidden, or outside the picture.
    pub touched: u64,
    /// Reads of these.
    pub reads: u64,
    /// Reads of the one that was read most often.
    pub most_reads: u64,
    /// Bytes read, as they are stored.
    pub bytes: u64,
    /// Lost chunks that are holes in the picture, where that was allowed.
    pub holes: u64,
    /// The most bytes of a volume's budget that were reserved at a time.
    pub planned_bytes: u64,
}

/// Times and counts of the last frame.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct RenderStatistics {
    /// Seconds per stage.
    pub seconds: StageSeconds,
    /// Threads of the pool.
    pub threads: usize,
    /// Which engine rendered it: `sheets`, `splats` or `classic`, or `gpu`.
    pub engine: &'static str,
    /// The device that rendered it, as its driver names it; empty for the processor.
    pub device: String,
    /// Seconds that its passes took there, by the device's timestamps; empty where it has none, and for the processor.
    pub passes: Vec<PassSeconds>,
    /// Why the processor rendered it, where a device was preferred; empty elsewhere.
    pub why: String,
    /// Vector instructions that it used; `scalar` for none.
    pub simd: &'static str,
    /// Level of detail: 0 is the volume itself, each further one half of it.
    pub level: usize,
    /// Levels that were drawn: that one, with the next where two are blended, or several behind each other.
    pub levels: usize,
    /// Bricks of the volume.
    pub bricks: usize,
    /// Bricks that can be seen with this transfer function.
    pub active_bricks: usize,
    /// Bricks whose samples were searched for visible ones in this frame; what earlier frames found in the others is
    /// still right (`sheets` and `gpu`, volumes).
    pub searched_bricks: usize,
    /// Bricks whose kernel coefficients were computed in this frame; those of the others were kept (`sheets` and `gpu`,
    /// volumes).
    pub solved_bricks: usize,
    /// Sheets from front to back.
    pub sheets: usize,
    /// Runs of sheets with a raster of their own, of all layers.
    pub zones: usize,
    /// Tiles of the picture.
    pub tiles: usize,
    /// Bricks opened, summed over tiles (`sheets`, grids).
    pub opened_bricks: u64,
    /// Voxels activated, summed over tiles.
    pub voxels: u64,
    /// Footprint slices splatted, summed over tiles and sheets.
    pub slices: u64,
    /// Vectors of sixteen voxels that were looked at, summed over tiles (`sheets`, grids).
    pub activated_vectors: u64,
    /// Vectors of four sheets by two by two pixels that were added to, summed over tiles (`sheets`, grids; none where
    /// footprints are evaluated pixel by pixel).
    pub splatted_vectors: u64,
    /// Vectors of sixteen pixels that were shaded, summed over intervals (`sheets`, post-classified by differences).
    pub shaded_vectors: u64,
    /// Pixels of these vectors that hold material.
    pub shaded_pixels: u64,
    /// Bricks left out for being hidden, summed over tiles (the papers' methods).
    pub hidden_bricks: u64,
    /// Hidden voxels that were skipped, summed over tiles: those of hidden bricks, and hidden ones of other bricks
    /// (the papers' methods).
    pub hidden_voxels: u64,
    /// Share of them among the voxels that could be seen, hidden and drawn (the papers' methods).
    pub hidden_share: f64,
    /// Pixels that are means of several samples ([`splatvol_scene::Coverage`]). Times include theirs, other counts
    /// do not.
    pub sampled_pixels: u64,
    /// Chunks read of volumes that are larger than memory; zeros for all others.
    pub chunks: ChunkStatistics,
    /// Memory held by the renderer after the frame.
    pub memory: MemoryUse,
}

impl RenderStatistics {
    /// Of two windows of a picture: times and what is counted per tile are added, all else is that of the second.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            seconds: self.seconds.plus(&other.seconds),
            searched_bricks: self.searched_bricks + other.searched_bricks,
            solved_bricks: self.solved_bricks + other.solved_bricks,
            tiles: self.tiles + other.tiles,
            opened_bricks: self.opened_bricks + other.opened_bricks,
            voxels: self.voxels + other.voxels,
            slices: self.slices + other.slices,
            activated_vectors: self.activated_vectors + other.activated_vectors,
            splatted_vectors: self.splatted_vectors + other.splatted_vectors,
            shaded_vectors: self.shaded_vectors + other.shaded_vectors,
            shaded_pixels: self.shaded_pixels + other.shaded_pixels,
            hidden_bricks: self.hidden_bricks + other.hidden_bricks,
            hidden_voxels: self.hidden_voxels + other.hidden_voxels,
            sampled_pixels: self.sampled_pixels + other.sampled_pixels,
            chunks: self.chunks.plus(&other.chunks),
            ..other.clone()
        }
    }
}
