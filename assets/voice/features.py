"""What the network hears of sound, as avatar/voice/mel_features.cpp, which a test compares."""
import numpy as np

RATE = 16000  # samples per second
HOP, WINDOW, FFT = 160, 320, 512  # samples
BANDS = 40
LOWEST, HIGHEST = 60.0, 7600.0  # Hz
FLOOR = 1e-8  # power, added to each band's; a full sine is some 1e4


def mel_filters():
    """[BANDS, FFT / 2 + 1]: triangles of equal width in mel, of height 1."""
    mel = lambda f: 1127 * np.log1p(f / 700)
    edges = 700 * np.expm1(np.linspace(mel(LOWEST), mel(HIGHEST), BANDS + 2) / 1127)
    f = np.arange(FFT // 2 + 1) * RATE / FFT
    rise = (f[None] - edges[:-2, None]) / (edges[1:-1] - edges[:-2])[:, None]
    fall = (edges[2:, None] - f[None]) / (edges[2:] - edges[1:-1])[:, None]
    return np.maximum(0, np.minimum(rise, fall))


FILTERS = mel_filters()
HANN = 0.5 - 0.5 * np.cos(2 * np.pi * (np.arange(WINDOW) + 0.5) / WINDOW)


def log_mel(x):
    """Samples from -1 to 1 -> [frames, BANDS]."""
    frames = max(0, (len(x) - WINDOW) // HOP + 1)
    at = np.arange(frames)[:, None] * HOP + np.arange(WINDOW)[None]
    power = np.abs(np.fft.rfft(x[at] * HANN, FFT)) ** 2
    return np.log(power @ FILTERS.T + FLOOR)


# The running mean of speech: what microphone, room and level add.
MEAN_FRAMES, FIRST_FRAMES = 300, 30
SPEECH_BELOW_PEAK = 4.0  # nats of power
PEAK_DECAY = 0.005  # nats per frame
FIRST_PEAK = -2.0  # nats of a frame's mean
LEAST, MOST = -8.0, 6.0


def normalise(e, prior):
    """Log-mel less its running mean over frames of speech."""
    mean, count, peak = prior.copy(), FIRST_FRAMES, FIRST_PEAK
    out = np.empty_like(e)
    for k, frame in enumerate(e):
        level = frame.mean()
        peak = max(level, peak - PEAK_DECAY)
        if level > peak - SPEECH_BELOW_PEAK:
            count = min(count + 1, MEAN_FRAMES)
            mean += (frame - mean) / count
        out[k] = np.clip(frame - mean, LEAST, MOST)
    return out / 3
