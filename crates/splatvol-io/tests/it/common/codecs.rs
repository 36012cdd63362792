//! Streams of compressions for which there is no encoder in Rust here, written by the libraries named, through the Python
//! packages `imagecodecs` and `numcodecs`. Base64. Pictures of 8 x 6 pixels, those of JPEG 2000 of 32 x 32: words are
//! `100 x + 37 y + (x x y mod 11)`, bytes `10 x + 7 y`.
#![allow(
    dead_code,
    unreachable_pub,
    clippy::expect_used,
    reason = "every test file uses its own part of these; constants are valid"
)]

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// The bytes of a stream.
pub fn stream(text: &str) -> Vec<u8> {
    STANDARD
        .decode(text.replace(['\n', ' '], ""))
        .expect("constants are valid")
}

/// Words of a DICOM slice, by JPEG-LS (`CharLS`).
pub const JPEG_LS: &str = "\
    /9j/6AAgU1BJRkYAAgAAAQAAAAYAAAAIChAGAQAAASwAAAEs/+gACAAAAAH/2P/3AAsQAAYACAEBEQD/+AANAf//ABIAQwEUAED/\
    2gAIAQEAAAAApjzHmLMeYth2DEqJkUJYk6kUaKkSqBRJtQry6ilEi0oqqgsK6OpGqKyeqo6Ok6RJ6krTr16bAP/Z";
/// The same, by lossless JPEG (libjpeg-turbo).
pub const JPEG_LOSSLESS: &str = "\
    /9j/xAAYAAEBAQEBAAAAAAAAAAAAAAAFBAcGEP/DAAsQAAYACAEAEQD/2gAIAQAABgAA9smybJsmybJsnSqLNJpqLdKoteymot0q\
    lalzKlfSqLXs0XudKotfcypW/9k=";
/// Words, by reversible JPEG 2000 with two levels of wavelets (`OpenJPEG`).
pub const JPEG_2000: &str = "\
    /0//UQApAAAAAAAgAAAAIAAAAAAAAAAAAAAAIAAAACAAAAAAAAAAAAABDwEB/1IADAAAAAEAAgQEAAH/XAAKQICIiJCIiJD/ZAAl\
    AAFDcmVhdGVkIGJ5IE9wZW5KUEVHIHZlcnNpb24gMi41LjT/kAAKAAAAAAKPAAH/k8/8MagRUFSvg4GEIAI+95j/MOFtz22ZCULU\
    0Kzl3zYOALaKkpJUIXsdcupK1eKUtykQJAsAiw25rkizJf1jMHUzp15QyVDqmV0JWdNI6rBMG7batIlT5ZLfL2Yb0H+dDY4yh7n5\
    Oi8TeZFn/jafwA/AngA+0qgAD5EQNqGFORgQWaZdQMJjoD18vWarI65rupoAVc6I6ghkv8ep0REXgAYXPaY0H9eoxOpgk1QYCjrC\
    4ED2ucMd2Iz2fObZOdn9IgQaV27GiU65cHw3GUvaWahefygwquxfB0FGcYIx6ImH9AXgVDN6/31lhoTi38AH20DAA+qgoAA+TQhf\
    p8cDkNekx6HPYrWVLa1XiznB8VRG19JoXtWtrtRnQFlzYTn1j48jxvKARflv+tDAWXWgRCdL2YHABKqQ3a5cqQ5UeoT7xZTHz1ij\
    jRlm0GtbO3fH2Gp4VbxKi51GJZExlif1mMYOomZUrOcyseaMGOjOY+j2J9J/RUnZaoFvcJ+drCk/oJiceJVGLOPOIeEfMhjfoFI+\
    73OkM8w1pEKgNrOnS+z85PWHrgCQb555NdZDNPaD/BZ8yFpoNbLWP5kiIg5degPNpYuozAvT4A5vkuLAwuy6uwyyR4VsLNj4Oz3o\
    erTmKoDPjhk41Y6bVJXCgnoU+uMqed1GdDbdiO6CzipQIBvvBxTHvpFFJCs00ggtlbF2g8KS8mLNU9XoB7pKRgtVeuiVgPf8zt3m\
    KmgLZzdK/BSrfOjKpz9JsUqykOud8e/Q2zq51Lgp8FhiWaGE8Zyq53yXr1iWDydDPgVVjf8PcRJnYBPcR3jxpQdfRn1SjUaED9tj\
    JafPzstk7ig/QuJDxrV//9k=";
/// The same, by irreversible JPEG 2000.
pub const JPEG_2000_LOSSY: &str = "\
    /0//UQApAAAAAAAgAAAAIAAAAAAAAAAAAAAAIAAAACAAAAAAAAAAAAABDwEB/1IADwECAAEAAgQEAACIiIj/XAARQp9SkAWQBZBH\
    l9OX05di/2QAJQABQ3JlYXRlZCBieSBPcGVuSlBFRyB2ZXJzaW9uIDIuNS40/5AACgAAAAABRQAB/5PP/EHsEVA6kWP1B2u28AMJ\
    BswcAwU1OJ3KaDyo01HdwtphuTcp7ShBNjHE78pU8ou/IfvZQvw18ykZCV+vpAaC+WWHXG3H5Wo1U2rO/CRD2pbzvygNXXKZ/pBQ\
    IXBgnbcbzYxhvStZcCfMkMohgRiAevaF6dM9FbjRjhM3BuufwA+wegA+obgADo42oZcomWFnIZODoCRpEp4BdhRHrigvpqJZO3Vi\
    vnk9pjQCFsVQLiM43Y+ufp2smRN02TmjJbUJG04i8N1yetWPwAPlPwAHyOoAA4lfp8eCgHMcsVMCj3zyZdfQZaAGs1KdfOLx4Lxf\
    9/9Tnax6c78m+CIIyJewjK2MP/V0fu0rNzDM9ovWYPPBy0aYTsG/i2QLZEII/Q7Rygk2lQxZMFSeFZ3ZcWFLVVpogTdKGP/Z";
/// Bytes, by baseline JPEG (libjpeg-turbo).
pub const JPEG: &str = "\
    /9j/4AAQSkZJRgABAQAAAQABAAD/2wBDAAIBAQEBAQIBAQECAgICAgQDAgICAgUEBAMEBgUGBgYFBgYGBwkIBgcJBwYGCAsICQoK\
    CgoKBggLDAsKDAkKCgr/wAALCAAGAAgBAREA/8QAHwAAAQUBAQEBAQEAAAAAAAAAAAECAwQFBgcICQoL/8QAtRAAAgEDAwIEAwUF\
    BAQAAAF9AQIDAAQRBRIhMUEGE1FhByJxFDKBkaEII0KxwRVS0fAkM2JyggkKFhcYGRolJicoKSo0NTY3ODk6Q0RFRkdISUpTVFVW\
    V1hZWmNkZWZnaGlqc3R1dnd4eXqDhIWGh4iJipKTlJWWl5iZmqKjpKWmp6ipqrKztLW2t7i5usLDxMXGx8jJytLT1NXW19jZ2uHi\
    4+Tl5ufo6erx8vP09fb3+Pn6/9oACAEBAAA/APzi/ZJ+Dek/6LzH27V//9k=";
/// Colours, by baseline JPEG: `10 x + 7 y`, `35 + 10 x - 7 y` and `70 - 10 x + 7 y`, with chrominances of half the size.
pub const JPEG_COLORS: &str = "\
    /9j/4AAQSkZJRgABAQAAAQABAAD/2wBDAAIBAQEBAQIBAQECAgICAgQDAgICAgUEBAMEBgUGBgYFBgYGBwkIBgcJBwYGCAsICQoK\
    CgoKBggLDAsKDAkKCgr/2wBDAQICAgICAgUDAwUKBwYHCgoKCgoKCgoKCgoKCgoKCgoKCgoKCgoKCgoKCgoKCgoKCgoKCgoKCgoK\
    CgoKCgoKCgr/wAARCAAGAAgDASIAAhEBAxEB/8QAHwAAAQUBAQEBAQEAAAAAAAAAAAECAwQFBgcICQoL/8QAtRAAAgEDAwIEAwUF\
    BAQAAAF9AQIDAAQRBRIhMUEGE1FhByJxFDKBkaEII0KxwRVS0fAkM2JyggkKFhcYGRolJicoKSo0NTY3ODk6Q0RFRkdISUpTVFVW\
    V1hZWmNkZWZnaGlqc3R1dnd4eXqDhIWGh4iJipKTlJWWl5iZmqKjpKWmp6ipqrKztLW2t7i5usLDxMXGx8jJytLT1NXW19jZ2uHi\
    4+Tl5ufo6erx8vP09fb3+Pn6/8QAHwEAAwEBAQEBAQEBAQAAAAAAAAECAwQFBgcICQoL/8QAtREAAgECBAQDBAcFBAQAAQJ3AAEC\
    AxEEBSExBhJBUQdhcRMiMoEIFEKRobHBCSMzUvAVYnLRChYkNOEl8RcYGRomJygpKjU2Nzg5OkNERUZHSElKU1RVVldYWVpjZGVm\
    Z2hpanN0dXZ3eHl6goOEhYaHiImKkpOUlZaXmJmaoqOkpaanqKmqsrO0tba3uLm6wsPExcbHyMnK0tPU1dbX2Nna4uPk5ebn6Onq\
    8vP09fb3+Pn6/9oADAMBAAIRAxEAPwD8zv2ctSk/cHntRRRXyPillmA/1tq/u1/TPqMFlGW+wX7pH//Z";
/// 0 to 23 as words, by Blosc.
pub const BLOSC_LZ4: &str = "\
    AgEzAjAAAAAwAAAAQAAAAAAAAQACAAMABAAFAAYABwAIAAkACgALAAwADQAOAA8AEAARABIAEwAUABUAFgAXAA==";
/// 0 to 23 as words, by Blosc.
pub const BLOSC_ZSTD: &str = "\
    AgGTAjAAAAAwAAAAQAAAAAAAAQACAAMABAAFAAYABwAIAAkACgALAAwADQAOAA8AEAARABIAEwAUABUAFgAXAA==";
/// 0 to 23 as words, by Blosc.
pub const BLOSC_ZLIB: &str = "\
    AgFzAjAAAAAwAAAAQAAAAAAAAQACAAMABAAFAAYABwAIAAkACgALAAwADQAOAA8AEAARABIAEwAUABUAFgAXAA==";
/// Words of 12 bits, by extended JPEG (libjpeg-turbo).
pub const JPEG_12: &str = "\
    /9j/4AAQSkZJRgABAQAAAQABAAD/2wBDAAIBAQEBAQIBAQECAgICAgQDAgICAgUEBAMEBgUGBgYFBgYGBwkIBgcJBwYGCAsICQoK\
    CgoKBggLDAsKDAkKCgr/wQALDAAGAAgBAREA/8QAFAABAAAAAAAAAAAAAAAAAAAADf/EACEQAAECBAcAAAAAAAAAAAAAAAIRMQED\
    ByIABAUKCxQh/9oACAEBAAA/AB1Tg2tvZQMJNHBmjpRRiOQJeuSpa9vrNj//2Q==";
/// The same colours, by JPEG-LS, interleaved by pixel.
pub const JPEG_LS_COLORS: &str = "\
    /9j/6AAgU1BJRkYAAgAAAwAAAAYAAAAICggGAQAAASwAAAEs/+gACAAAAAH/2P/3ABEIAAYACAMBEQACEQADEQD/2gAMAwEAAgAD\
    AAACAEAAACigHAQOcHTWJTWTRYRRYR+I/ysMKKNJlVo+8xpYKvPe972y5P73Oc5q5u3d3do67u7u77D/2Q==";
