#!/usr/bin/env python3
"""Makes voice_net.bin: the network by which avatar/voice hears visemes.

    python3 make_voice_net.py voice_net.bin
    python3 make_voice_net.py --hold slt,rms,dita,pc held_out.bin     # to be measured on those
    python3 make_voice_net.py --hold slt,rms,dita,pc --evaluate COSPLAT # built with it

It needs Debian's python3-torch, libespeak-ng1, festival with the voices below, and flite; some 40
minutes of one core. Synthesis says when each phoneme begins: half of the speech is espeak-ng's, in
nine languages by voices of many pitches, rates and throats; half is of fourteen recorded people.
Rooms, noise and cheap microphones are put on top. What the network is to say of each frame are the
weights of 15 visemes (the order of avatar/voice/visemes.h) with coarticulation: neighbours overlap by
dominance functions (Cohen and Massaro 1993, "Modeling coarticulation in synthetic visual speech"),
and a closure of the lips is never lost. The features are those of avatar/voice/mel_features.cpp; a
test holds the two against each other. Same seed and versions, same bytes.
"""
import argparse
import csv
import ctypes
import struct
import subprocess
import tempfile
import wave

import numpy as np
import torch

RATE = 16000  # samples per second
HOP, WINDOW, FFT = 160, 320, 512  # samples
BANDS = 40
LOWEST, HIGHEST = 60.0, 7600.0  # Hz
FLOOR = 1e-8  # power, added to each band's; a full sine is some 1e4
LOOK_AHEAD = 4  # frames
VISEMES = "sil PP FF TH DD kk CH SS nn RR aa E ih oh ou".split()
FRONT, HIDDEN = 64, 128

# ---------------------------------------------------------------- features


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


# ---------------------------------------------------------------- phonemes

# Visemes of IPA's letters; of several, the first that fits. A diphthong is two.
IPA = [
    ("tʃ dʒ tɕ dʑ ʃ ʒ ɕ ʑ ʂ ʐ", "CH"), ("ts dz s z", "SS"), ("θ ð", "TH"), ("p b m ɓ β", "PP"),
    ("f v ɱ ʋ", "FF"), ("t d ʈ ɖ ɗ", "DD"), ("k ɡ g x ɣ h ɦ ŋ c ɟ ç χ ʁ ʔ q ʀ", "kk"),
    ("n l ɲ ʎ ɫ ɳ ɭ", "nn"), ("ɹ r ɾ ɝ ɚ ɜ ɻ", "RR"), ("a ɑ æ ɐ ʌ", "aa"), ("e ɛ ə ɘ", "E"),
    ("i ɪ j ɨ", "ih"), ("o ɔ ɒ ø œ ɵ", "oh"), ("u ʊ w ɯ y ʏ ɥ ʉ", "ou")]
LETTERS = [(letter, viseme) for letters, viseme in IPA for letter in letters.split()]
# Of Festival's and flite's phonemes, less lengths and stresses. Languages differ in a few.
NAMES = dict(
    sil="# pau _", PP="p b m pp bb mm", FF="f v nf", TH="th dh", DD="t d", kk="k g hh ng h x G N",
    CH="ch jh sh zh tS dZ S Z", SS="s z ts dz", nn="n l J L", RR="r er rr R", aa="aa ae ah a A",
    E="ax eh e E @", ih="ih iy y i j I", oh="ao o O", ou="uh uw w u U")
VISEME_OF = {name: viseme for viseme, names in NAMES.items() for name in names.split()}
VISEME_OF.update({"ey": "E ih", "ow": "oh ou", "oy": "oh ih", "aw": "aa ou", "ay": "aa ih"})
CZECH = {"c": "SS", "c~": "CH", "s~": "CH", "z~": "CH", "r~": "CH", "ch": "kk", "d~": "DD",
         "t~": "DD", "n~": "nn", "dz~": "CH"}
FINNISH = {"y": "ou", "oe": "oh", "ae": "aa"}


def visemes_of_ipa(name):
    found = []
    while name:
        for letter, viseme in LETTERS:
            if name.startswith(letter):
                found.append(viseme)
                name = name[len(letter):]
                break
        else:
            name = name[1:]  # length, stress, nasality
    return found[:2]


# How strongly a viseme holds against its neighbours, and how far beyond its segment, seconds.
DOMINANCE = dict(
    sil=(1.0, .05), PP=(30, .012), FF=(8, .018), TH=(1.5, .03), DD=(.7, .025), kk=(.35, .025),
    CH=(3, .035), SS=(1.5, .025), nn=(.6, .03), RR=(1.3, .035), aa=(1.6, .04), E=(1.2, .035),
    ih=(1.3, .035), oh=(2, .045), ou=(2.2, .05))


def weights_of(segments, frames):
    """[(viseme, begin, end)], seconds -> [frames, 15]; time k is the middle of frame k."""
    t = (np.arange(frames) * HOP + WINDOW / 2) / RATE
    total = np.full((frames, len(VISEMES)), 1e-9)
    for viseme, begin, end in segments:
        strength, reach = DOMINANCE[viseme]
        away = np.maximum(0, np.maximum(begin - t, t - end))
        total[:, VISEMES.index(viseme)] += strength * np.exp(-away / reach)
    return total / total.sum(1, keepdims=True)


ESPEAK_CLOSURE = 0.06  # seconds of silence before the burst, where espeak-ng's event of p, t, k is


def segments_of(phonemes, end, closure):
    """[(name, visemes, begin)] -> [(viseme, begin, end)]; closure: seconds before p, t and k."""
    segments = []
    for i, (name, visemes, begin) in enumerate(phonemes):
        stop = phonemes[i + 1][2] if i + 1 < len(phonemes) else end
        if closure and name[:1] in ("p", "t", "k", "c", "q") and segments:
            closed = max(begin - closure, 0.5 * (segments[-1][1] + segments[-1][2]))
            segments[-1] = (*segments[-1][:2], min(segments[-1][2], closed))
            if visemes == ["PP"]:  # the lips are open while breath follows
                stop = min(stop, begin + 0.015)
            begin = closed
        if name in ("h", "ɦ", "ʔ", "hh"):  # of the vowel that follows
            continue
        for k, viseme in enumerate(visemes):
            step = (stop - begin) / len(visemes)
            segments.append((viseme, begin + k * step, begin + (k + 1) * step))
    return segments


# ---------------------------------------------------------------- speech

WORDS = """
the of and to in is you that it he was for on are as with his they at be this from have or by one
had not but what all were when we there can an your which their said if do will each about how up
out them then she many some so these would other into has more her two like him see time could no
make than first been its who now people my made over did down only way find use may water long
little very after words called just where most know get through back much before go good new write
our used me man too any day same right look think also around another came come work three must
because does part even place well such here take why things help put years different away again off
went old number great tell men say small every found still between name should home big give air
line set own under read last never us left end along while might next sound below saw something
thought both few those always looked show large often together asked house world going want school
important until form food keep children feet land side without boy once animals life enough took
sometimes four head above kind began almost live page got earth need far hand high year mother
light parts country father let night following picture being study second eyes soon times story
boys since white days ever paper hard near sentence better best across during today others however
sure means knew try told young miles sun ways thing whole hear example heard several change answer
room sea against top turned learn point city play toward five using himself usually money seen car
morning body upon family later turn move face door cut done group true half red fish plants living
wanted black eat short run book gave order open ground cold really table remember tree course front
American space inside ago sad early learned brought close nothing though idea before lived became
add become grow draw yet less wind behind cannot letter among able dog shown mean English rest
perhaps certain six feel fire ready green yes built special ran full town complete oh person hot
anything hold state list stood hundred shape ten fast felt kept notice voice power problem map
bubble vivid pepper maybe thumb measure church judge zoo whisper shadow yellow forever of above
vision azure boil join cube view fuel huge bumping member people probably above puppy bamboo mommy
pump bob mop lamb five wife leaf love
""".split()
LANGUAGES = "en-us en-us en-us en-us en en en-gb-x-rp en-gb-scotland de de fr es it pt nl pl sv".split()
VARIANTS = [""] * 2 + [f"+m{i}" for i in range(1, 9)] + [f"+f{i}" for i in range(1, 6)] + [
    "+Andy", "+Annie", "+Andrea", "+Denis", "+Diogo", "+Gene", "+Jacky", "+Lee", "+linda",
    "+Marco", "+Michael", "+pablo", "+steph", "+Storm", "+belinda", "+adam", "+Mike", "+klatt4"]


class Event(ctypes.Structure):
    _fields_ = [("type", ctypes.c_int), ("identifier", ctypes.c_uint), ("text", ctypes.c_int),
                ("length", ctypes.c_int), ("milliseconds", ctypes.c_int), ("sample", ctypes.c_int),
                ("user", ctypes.c_void_p), ("name", ctypes.c_char * 8)]


class Speaker:
    """espeak-ng's library: text -> samples and phonemes."""

    SYNCHRONOUS, PHONEME_EVENTS, IPA, PHONEME = 2, 1, 2, 7

    def __init__(self):
        self.library = ctypes.CDLL("libespeak-ng.so.1")
        self.rate = self.library.espeak_Initialize(
            self.SYNCHRONOUS, 0, None, self.PHONEME_EVENTS | self.IPA)
        self.sound, self.phonemes = [], []
        callback = ctypes.CFUNCTYPE(
            ctypes.c_int, ctypes.POINTER(ctypes.c_short), ctypes.c_int, ctypes.POINTER(Event))
        self.callback = callback(self._take)
        self.library.espeak_SetSynthCallback(self.callback)

    def _take(self, sound, count, events):
        if sound and count > 0:
            self.sound.append(np.ctypeslib.as_array(sound, (count,)).copy())
        i = 0
        while events[i].type:
            if events[i].type == self.PHONEME:
                name = bytes(events[i].name).split(b"\0")[0].decode("utf-8", "ignore")
                self.phonemes.append((name, events[i].milliseconds / 1000))
            i += 1
        return 0

    def say(self, text, voice, pitch, words_per_minute):
        self.sound, self.phonemes = [], []
        if self.library.espeak_SetVoiceByName(voice.encode()):
            raise SystemExit(f"espeak-ng has no voice {voice}")
        self.library.espeak_SetParameter(1, words_per_minute, 0)
        self.library.espeak_SetParameter(3, pitch, 0)
        data = text.encode() + b"\0"
        self.library.espeak_Synth(data, len(data), 0, 0, 0, 1, None, None)
        x = np.concatenate(self.sound) / 32768.0
        phonemes = []
        for name, begin in self.phonemes:
            if name.startswith("("):
                continue  # of another language
            visemes = visemes_of_ipa(name) or (["sil"] if name in ("", "_", "_:") else [])
            if visemes:
                phonemes.append((name, visemes, begin))
        return resample(x, RATE / self.rate), phonemes


# Recorded people by diphones or statistics: voice, how to load it, what it reads.
FESTIVAL = {
    "kal": ("voice_kal_diphone", "en"), "ked": ("voice_ked_diphone", "en"),
    "slt": ("voice_cmu_us_slt_arctic_hts", "en"), "lp": ("voice_lp_diphone", "it"),
    "pc": ("voice_pc_diphone", "it"), "dita": ("voice_czech_dita", "cs"),
    "krb": ("voice_czech_krb", "cs"), "machac": ("voice_czech_machac", "cs"),
    "ph": ("voice_czech_ph", "cs"), "lj": ("voice_suo_fi_lj_diphone", "fi"),
    "mv": ("voice_hy_fi_mv_diphone", "fi"), "ona": ("voice_upc_ca_ona_hts", "ca")}
FLITE = ("awb", "rms")
FESTIVAL_SAYS = """(define (say voice text file) (eval (list voice))
 (let ((u (utt.synth (eval (list 'Utterance 'Text text)))))
  (utt.save.wave u (string-append file ".wav") 'riff)
  (utt.save.segs u (string-append file ".lab"))))
"""


def visemes_of_name(name, language):
    own = {"cs": CZECH, "fi": FINNISH}.get(language, {})
    for known in (own, VISEME_OF):
        for spelled in (name, name.rstrip("0123456789:~"), name.rstrip("0123456789:~").lower()):
            if spelled in known:
                return known[spelled].split()
    return []


def read_wav(path):
    with wave.open(path) as file:
        x = np.frombuffer(file.readframes(file.getnframes()), np.int16) / 32768.0
        return resample(x, RATE / file.getframerate())


def recordings(sentences):
    """[(speaker, text)] -> [(speaker, samples, [(name, visemes, begin)])]."""
    out = []
    with tempfile.TemporaryDirectory() as folder:
        script = [FESTIVAL_SAYS]
        for i, (speaker, text) in enumerate(sentences):
            if speaker in FESTIVAL:
                script.append(f'(say \'{FESTIVAL[speaker][0]} "{text}" "{folder}/{i}")\n')
        open(f"{folder}/all.scm", "w").write("".join(script))
        subprocess.run(["festival", "-b", f"{folder}/all.scm"], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for i, (speaker, text) in enumerate(sentences):
            names, ends = [], []
            if speaker in FESTIVAL:
                for line in open(f"{folder}/{i}.lab").read().split("\n")[1:]:
                    if line:
                        end, _, name = line.split()[:3]
                        names.append(name), ends.append(float(end))
            else:
                said = subprocess.run(
                    ["flite", "-voice", speaker, "-psdur", "-t", text, "-o", f"{folder}/{i}.wav"],
                    check=True, capture_output=True, text=True).stdout
                for token in said.split():
                    name, end = token.split(":")
                    names.append(name), ends.append(float(end))
            language = FESTIVAL.get(speaker, ("", "en"))[1]
            phonemes, begin = [], 0.0
            for name, end in zip(names, ends):
                visemes = visemes_of_name(name, language)
                if not visemes:
                    raise SystemExit(f"{speaker}: no viseme of '{name}' in '{text}'")
                phonemes.append((name, visemes, begin))
                begin = end
            out.append((speaker, read_wav(f"{folder}/{i}.wav"), phonemes))
    return out


SYLLABLES = dict(
    it=("p b m f v t d n l r k g s z ch gh sc gl gn qu c pr br tr st sp".split(), "aeiou"),
    cs=("p b m f v t d n l r k h s z c j ch pr br st".split(), "aeiou"),
    fi=("p m v t n l r k h s j pp mm tt".split(), "aeiouy"),
    ca=("p b m f v t d n l r c g s x ny ll".split(), "aeiou"))


def invented(rng, language):
    """Words that no language has, by its spelling."""
    begins, vowels = SYLLABLES[language]
    return " ".join(
        "".join(rng.choice(begins) + rng.choice(list(vowels)) for _ in range(rng.integers(1, 4)))
        for _ in range(rng.integers(4, 9)))


def resample(x, factor):
    """By its spectrum: `factor` times as many samples."""
    n = int(round(len(x) * factor))
    spectrum = np.fft.rfft(x)
    out = np.zeros(n // 2 + 1, complex)
    m = min(len(out), len(spectrum))
    out[:m] = spectrum[:m]
    return np.fft.irfft(out, n) * (n / len(x))


def text_of(rng, language):
    if language.startswith("en") and rng.random() < 0.85:
        words = list(rng.choice(WORDS, rng.integers(4, 11)))
        if rng.random() < 0.3:
            words.insert(int(rng.integers(1, len(words))), "…,")
        return " ".join(words) + rng.choice([".", "?", "!"])
    return ", ".join(str(rng.integers(1, 10 ** int(rng.integers(1, 6)))) for _ in range(3))


def through_a_room(rng, x):
    """What lies between a mouth and a file."""
    n = len(x)
    spectrum = np.fft.rfft(x)
    f = np.arange(len(spectrum)) * RATE / n
    tilt = sum(rng.normal(0, 2.5) * np.cos(np.pi * k * f / (RATE / 2)) for k in range(1, 4))
    gain = 10 ** (tilt / 20)
    if rng.random() < 0.15:  # a telephone
        gain = gain / (1 + (250 / np.maximum(f, 1)) ** 4) / (1 + (f / 3400) ** 8)
    x = np.fft.irfft(spectrum * gain, n)
    if rng.random() < 0.3:
        tail = np.arange(int(0.3 * RATE)) / RATE
        echo = rng.normal(size=len(tail)) * np.exp(-tail * 6.9 / rng.uniform(0.08, 0.35))
        echo *= 10 ** (rng.uniform(-20, -8) / 20) / np.sqrt((echo ** 2).sum())
        echo[0] += 1
        x = np.fft.irfft(np.fft.rfft(x, n + len(tail)) * np.fft.rfft(echo, n + len(tail)))[:n]
    if rng.random() < 0.7:
        noise = np.fft.rfft(rng.normal(size=n)) / np.maximum(f, 50) ** rng.uniform(0, 1)
        noise = np.fft.irfft(noise, n)
        x = x + noise * (x.std() / noise.std() * 10 ** (-rng.uniform(8, 50) / 20))
    return x * (10 ** (rng.uniform(-42, -10) / 20) / (x.std() + 1e-6))


def heard(rng, utterances, closure):
    """[(samples, phonemes)] of one speaker, in one room -> log-mel and weights."""
    stretch = rng.uniform(0.86, 1.16)  # another throat
    samples, segments, begin = [], [], 0.0
    for x, phonemes in utterances:
        pause = rng.uniform(0.1, 0.8 if rng.random() < 0.8 else 3)
        begin += pause
        samples += [np.zeros(int(pause * RATE)), resample(x, stretch)]
        spoken = segments_of(phonemes, len(x) / RATE, closure)
        segments += [(v, b * stretch + begin, e * stretch + begin) for v, b, e in spoken]
        begin += len(samples[-1]) / RATE
    samples.append(np.zeros(int(rng.uniform(0.1, 1.5) * RATE)))
    ends = [-1] + [e for _, _, e in segments]
    begins = [b for _, b, _ in segments] + [1e3]
    segments += [("sil", e, b) for e, b in zip(ends, begins) if b > e + 0.02]
    e = log_mel(np.clip(through_a_room(rng, np.concatenate(samples)), -1, 1))
    return e, weights_of(segments, len(e)).astype(np.float32)


def text_for(rng, speaker):
    language = FESTIVAL.get(speaker, ("", "en"))[1]
    return text_of(rng, "en") if language == "en" else invented(rng, language)


TOGETHER = 3  # utterances of a speaker in a row


def corpus(seed, spoken, recorded, speakers):
    """[(log-mel, weights)] of rows of utterances: `spoken` by espeak-ng, `recorded` of each."""
    rng = np.random.default_rng(seed)
    speaker = Speaker()
    rows = []
    for _ in range(spoken):
        language = rng.choice(LANGUAGES)
        voice = language + rng.choice(VARIANTS), int(rng.integers(15, 95)), int(
            rng.integers(110, 250))
        said = [speaker.say(text_of(rng, language), *voice) for _ in range(TOGETHER)]
        rows.append(heard(rng, said, ESPEAK_CLOSURE))
    sentences = [(name, text_for(rng, name)) for name in speakers
                 for _ in range(recorded * TOGETHER)]
    said = [(x, phonemes) for _, x, phonemes in recordings(sentences)]
    for i in range(0, len(said), TOGETHER):
        rows.append(heard(rng, said[i:i + TOGETHER], 0))
    return rows


# ---------------------------------------------------------------- the network


class Net(torch.nn.Module):
    def __init__(self):
        super().__init__()
        self.front = torch.nn.Linear(BANDS, FRONT)
        self.recurrent = torch.nn.GRU(FRONT, HIDDEN, batch_first=True)
        self.output = torch.nn.Linear(HIDDEN, len(VISEMES))

    def forward(self, x):
        return self.output(self.recurrent(torch.relu(self.front(x)))[0])


def mean_of_speech(rows):
    speech = []
    for e, _ in rows:
        level = e.mean(1)
        speech.append(e[level > level.max() - SPEECH_BELOW_PEAK])
    return np.concatenate(speech).mean(0).astype(np.float32)


def train(rows, mean, seed, epochs):
    """Streams of rows side by side; the output is of LOOK_AHEAD frames before the input."""
    LENGTH, STREAMS, WARM_UP, RATE_OF_STEPS = 400, 32, 40, 3e-3
    torch.manual_seed(seed)
    rng = np.random.default_rng(seed)
    features = [normalise(e, mean).astype(np.float32) for e, _ in rows]
    net = Net()
    optimizer = torch.optim.Adam(net.parameters(), RATE_OF_STEPS)
    chunks = sum(map(len, features)) // (LENGTH * STREAMS)
    for epoch in range(epochs):
        order = rng.permutation(len(rows))
        x = np.concatenate([features[i] for i in order])[: chunks * LENGTH * STREAMS]
        y = np.concatenate([rows[i][1] for i in order])[: chunks * LENGTH * STREAMS]
        x, y = x.reshape(STREAMS, -1, BANDS), y.reshape(STREAMS, -1, len(VISEMES))
        loss = 0.0
        for chunk in range(chunks):
            at = slice(chunk * LENGTH, (chunk + 1) * LENGTH)
            done = (epoch + chunk / chunks) / epochs
            for group in optimizer.param_groups:
                group["lr"] = RATE_OF_STEPS * 0.5 * (1 + np.cos(np.pi * done))
            said = torch.log_softmax(net(torch.from_numpy(x[:, at])), -1)
            wanted = torch.from_numpy(y[:, at])
            step = -(said[:, WARM_UP + LOOK_AHEAD:] * wanted[:, WARM_UP:LENGTH - LOOK_AHEAD]).sum(
                -1).mean()
            optimizer.zero_grad()
            step.backward()
            torch.nn.utils.clip_grad_norm_(net.parameters(), 1.0)
            optimizer.step()
            loss += float(step)
        print(f"epoch {epoch + 1} of {epochs}: cross-entropy {loss / chunks:.3f}", flush=True)
    return net


def write(path, net, mean):
    """For avatar/voice/viseme_net.cpp; the rows of matrices in bytes, each with its scale."""
    g = net.recurrent
    layers = [(net.front.weight, net.front.bias), (g.weight_ih_l0, g.bias_ih_l0),
              (g.weight_hh_l0, g.bias_hh_l0), (net.output.weight, net.output.bias)]
    with open(path, "wb") as file:
        file.write(b"CSV1" + mean.astype("<f4").tobytes())
        for matrix, bias in layers:
            matrix, bias = matrix.detach().numpy(), bias.detach().numpy()
            file.write(struct.pack("<II", *matrix.shape))
            for row in matrix:
                scale = max(np.abs(row).max(), 1e-9) / 127
                file.write(struct.pack("<f", scale) + np.rint(row / scale).astype("i1").tobytes())
            file.write(bias.astype("<f4").tobytes())


# ---------------------------------------------------------------- how good it is

# How far each viseme opens and widens the lips, of 1.
OPENING = dict(TH=.25, DD=.25, kk=.3, CH=.2, SS=.2, nn=.25, RR=.25, aa=.8, E=.5, ih=.35, oh=.5,
               ou=.2, FF=.05)
WIDTH = dict(CH=-.4, SS=.3, RR=-.3, aa=.1, E=.2, ih=.35, oh=-.4, ou=-.7)
SENTENCES = """Please put the blue book back by the window, and bring me a cup of tea.
My mother made a big pot of mushroom soup for Bob and his puppy.
The quick brown fox jumps over the lazy dog while five boxing wizards watch.
We were away a year ago, when the weather was warm and the sea was blue.
How much wood would a woodchuck chuck, if a woodchuck could chuck wood?
I thought that you should know about the measure of pleasure in his voice.
Peter Piper picked a peck of pickled peppers; maybe Mary may buy them.
Today is Thursday, the twenty fifth of November, and it is very cold outside.""".split("\n")


def scores_of(program, x):
    """What the program makes of a sound: opening and width of the lips, 50 per second."""
    with tempfile.TemporaryDirectory() as folder:
        with wave.open(f"{folder}/x.wav", "wb") as file:
            file.setnchannels(1), file.setsampwidth(2), file.setframerate(RATE)
            file.writeframes((np.clip(x, -1, 1) * 32767).astype("<i2").tobytes())
        subprocess.run([program, "voice", f"{folder}/x.wav", "-o", f"{folder}/x.csv", "--quiet"],
                       check=True)
        rows = list(csv.DictReader(open(f"{folder}/x.csv")))
    column = lambda name: np.array([float(row[name]) for row in rows])
    opening = column("JawOpen") + 0.5 * column("MouthLowerDownLeft")
    width = (column("MouthStretchLeft") + column("MouthSmileLeft") - column("MouthPucker")
             - 0.6 * column("MouthFunnel"))
    return opening, width


def evaluate(lips, speakers, noise):
    """lips: samples -> opening and width, 50 per second. noise: dB of speech above it, or None."""
    rng = np.random.default_rng(7)
    sentences = []
    for speaker in speakers:
        english = FESTIVAL.get(speaker, ("", "en"))[1] == "en"
        sentences += [(speaker, s if english else text_for(rng, speaker)) for s in SENTENCES]
    spoken = recordings(sentences)
    for speaker in speakers:
        said, wanted, closures = [], [], []
        for name, x, phonemes in spoken:
            if name != speaker:
                continue
            if noise is not None:
                x = x + rng.normal(size=len(x)) * x.std() * 10 ** (-noise / 20)
            segments = segments_of(phonemes, len(x) / RATE, 0)
            w = weights_of(segments, len(x) // HOP)[::2]
            opening, width = lips(x)
            n = min(len(w), len(opening))
            said.append(np.stack([opening[:n], width[:n]]))
            wanted.append(np.stack([w[:n] @ [t.get(v, 0) for v in VISEMES]
                                    for t in (OPENING, WIDTH)]))
            for viseme, begin, end in segments:
                if viseme == "PP":
                    near = opening[max(0, int((begin - .03) * 50)):int((end + .03) * 50) + 1]
                    closures.append(len(near) > 0 and near.min() < 0.05)
        said, wanted = np.concatenate(said, 1), np.concatenate(wanted, 1)
        r = [np.corrcoef(a, b)[0, 1] for a, b in zip(said, wanted)]
        print(f"{speaker:7} opening r {r[0]:.2f}, width r {r[1]:.2f}, "
              f"{100 * np.mean(closures):.0f} % of {len(closures)} closures shut", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("file", nargs="?", help="voice_net.bin, to be made")
    parser.add_argument("--hold", default="", help="speakers to leave out, by commas")
    parser.add_argument("--evaluate", metavar="COSPLAT", help="hear --hold's speakers by this program")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--epochs", type=int, default=12)
    options = parser.parse_args()
    held = [name for name in options.hold.split(",") if name]
    if options.file:
        speakers = [name for name in [*FESTIVAL, *FLITE] if name not in held]
        rows = []
        for part in range(4):
            rows += corpus(4 * options.seed + part, 220, 50, speakers)
            minutes = sum(len(e) for e, _ in rows) * HOP / RATE / 60
            print(f"speech: {minutes:.0f} minutes", flush=True)
        mean = mean_of_speech(rows)
        write(options.file, train(rows, mean, options.seed, options.epochs), mean)
    if options.evaluate:
        for noise in (None, 15):
            print("clean" if noise is None else f"with white noise {noise} dB below the voice")
            evaluate(lambda x: scores_of(options.evaluate, x), held or [*FESTIVAL, *FLITE], noise)


if __name__ == "__main__":
    main()
