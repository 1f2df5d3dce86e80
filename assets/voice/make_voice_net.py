#!/usr/bin/env python3
"""Makes voice_net.bin: the network by which avatar/voice hears visemes.

    python3 make_voice_net.py voice_net.bin
    python3 make_voice_net.py --hold slt,rms,dita,pc held_out.bin     # to be measured on those
    python3 make_voice_net.py --hold slt,rms,dita,pc --evaluate COSPLAT # built with it

It needs Debian's python3-torch, libespeak-ng1, festival with the voices below, and flite; some 40
minutes of one core. Synthesis says when each phoneme begins: half of the speech is espeak-ng's, in
nine languages by voices of many pitches, rates and throats; half is of fourteen recorded people.
Rooms, noise and cheap microphones are put on top. What the network is to say of each frame are
the weights of 15 visemes (the order of avatar/voice/visemes.h) with coarticulation: neighbours
overlap by dominance functions (Cohen and Massaro 1993, "Modeling coarticulation in synthetic visual
speech"), and a closure of the lips is never lost. Same seed and versions, same bytes.
"""
import argparse
import csv
import struct
import subprocess
import tempfile
import wave

import numpy as np
import torch

from features import BANDS, HOP, RATE, SPEECH_BELOW_PEAK, normalise
from speech import (
    FESTIVAL, FLITE, VISEMES, corpus, language_of, recordings, segments_of, text_for, weights_of)

LOOK_AHEAD = 4  # frames
FRONT, HIDDEN = 64, 128
SEED, EPOCHS = 1, 12

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


def train(rows, mean):
    """Streams of rows side by side; the output is of LOOK_AHEAD frames before the input."""
    LENGTH, STREAMS, WARM_UP, RATE_OF_STEPS = 400, 32, 40, 3e-3
    torch.manual_seed(SEED)
    rng = np.random.default_rng(SEED)
    features = [normalise(e, mean).astype(np.float32) for e, _ in rows]
    net = Net()
    optimizer = torch.optim.Adam(net.parameters(), RATE_OF_STEPS)
    chunks = sum(map(len, features)) // (LENGTH * STREAMS)
    for epoch in range(EPOCHS):
        order = rng.permutation(len(rows))
        x = np.concatenate([features[i] for i in order])[: chunks * LENGTH * STREAMS]
        y = np.concatenate([rows[i][1] for i in order])[: chunks * LENGTH * STREAMS]
        x, y = x.reshape(STREAMS, -1, BANDS), y.reshape(STREAMS, -1, len(VISEMES))
        loss = 0.0
        for chunk in range(chunks):
            at = slice(chunk * LENGTH, (chunk + 1) * LENGTH)
            done = (epoch + chunk / chunks) / EPOCHS
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
        print(f"epoch {epoch + 1} of {EPOCHS}: cross-entropy {loss / chunks:.3f}", flush=True)
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


def evaluate(program, speakers, noise):
    """Each speaker says all sentences one after another. noise: dB of speech above it, or None."""
    rng = np.random.default_rng(7)
    spoken = recordings([
        (speaker, sentence if language_of(speaker) == "en" else text_for(rng, speaker))
        for speaker in speakers for sentence in SENTENCES])
    for speaker in speakers:
        sound, segments, begin = [], [], 0.0
        for name, x, phonemes in spoken:
            if name != speaker:
                continue
            x = x[:len(x) // HOP * HOP]
            sound.append(x)
            said = segments_of(phonemes, len(x) / RATE, 0)
            segments += [(v, b + begin, e + begin) for v, b, e in said]
            begin += len(x) / RATE
        x = np.concatenate(sound)
        if noise is not None:
            x = x + rng.normal(size=len(x)) * x.std() * 10 ** (-noise / 20)
        weights = weights_of(segments, len(x) // HOP)[::2]
        lips = scores_of(program, x)
        n = min(len(weights), len(lips[0]))
        r = [np.corrcoef(shown[:n], weights[:n] @ [table.get(v, 0) for v in VISEMES])[0, 1]
             for shown, table in zip(lips, (OPENING, WIDTH))]
        shut = [lips[0][max(0, int((b - .03) * 50)):int((e + .03) * 50) + 1].min() < 0.05
                for v, b, e in segments if v == "PP" and int(b * 50) < n]
        print(f"{speaker:5} opening r {r[0]:.2f}, width r {r[1]:.2f}, "
              f"{100 * np.mean(shut):.0f} % of {len(shut)} closures shut", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("file", nargs="?", help="voice_net.bin, to be made")
    parser.add_argument("--hold", default="", help="speakers to leave out, by commas")
    parser.add_argument(
        "--evaluate", metavar="COSPLAT", help="let this program hear those of --hold, or all")
    options = parser.parse_args()
    held = [name for name in options.hold.split(",") if name]
    if options.file:
        speakers = [name for name in [*FESTIVAL, *FLITE] if name not in held]
        rows = []
        for part in range(4):
            rows += corpus(4 * SEED + part, 220, 50, speakers)
            minutes = sum(len(e) for e, _ in rows) * HOP / RATE / 60
            print(f"speech: {minutes:.0f} minutes", flush=True)
        mean = mean_of_speech(rows)
        write(options.file, train(rows, mean), mean)
    if options.evaluate:
        for noise in (None, 15):
            print("clean" if noise is None else f"with white noise {noise} dB below the voice")
            evaluate(options.evaluate, held or [*FESTIVAL, *FLITE], noise)


if __name__ == "__main__":
    main()
