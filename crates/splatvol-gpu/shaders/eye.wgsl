// Eye: the plane at the eye of a camera within the volume, where all rays begin at one point, as `splatvol_cpu::sheets::eye`.

override FROM_EYE: bool = false;

fn is_eye(sheet: u32) -> bool {
    return FROM_EYE && sheets[sheet].scale == 0.0;
}
