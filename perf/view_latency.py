#!/usr/bin/env python3
"""Frames per second and latency of `phalanx view` in headless Chromium, as JSON, a line a scene.

    pip install playwright
    perf/view_latency.py target/release/phalanx SCENE... [--slow]

The mouse circles for ten seconds. Times are the page's own: latency is from the event of a mouse move to the drawing of the
frame that was asked for with it. With --slow, the page's connections pass a link of 40 ms there and back, and of 10 Mbit/s each
way. Chromium draws without a GPU, on the same cores as the tracer.
"""

import asyncio
import json
import math
import re
import subprocess
import sys
import threading
import time

from playwright.sync_api import sync_playwright

WINDOW = {"width": 1280, "height": 720}
SECONDS = 10
SAMPLES = 16

# Records every frame that is drawn.
RECORD = """() => {
  window.drawn = [];
  let last = null;
  const look = () => {
    if (phalanx.frame !== last) drawn.push({ at: performance.now(), ...(last = phalanx.frame) });
    requestAnimationFrame(look);
  };
  look();
}"""


class Link:
    """A direction of a link, shared by all connections."""

    def __init__(self, bytes_per_s, delay):
        self.bytes_per_s, self.delay, self.free = bytes_per_s, delay, 0.0

    def arrival(self, count):
        self.free = max(self.free, time.monotonic()) + count / self.bytes_per_s
        return self.free + self.delay

    async def carry(self, reader, writer):
        waiting = asyncio.Queue(64)

        async def deliver():
            while True:
                arrival, chunk = await waiting.get()
                await asyncio.sleep(max(0, arrival - time.monotonic()))
                if not chunk:
                    return writer.close()
                writer.write(chunk)
                await writer.drain()

        delivering = asyncio.create_task(deliver())
        while chunk := await reader.read(4096):
            await waiting.put((self.arrival(len(chunk)), chunk))
        await waiting.put((self.arrival(0), b""))
        await delivering


def slow_port(port):
    """A port that leads to `port` over a slow link."""
    found = []

    async def serve():
        up, down = Link(1.25e6, 0.02), Link(1.25e6, 0.02)

        async def connect(reader, writer):
            await asyncio.sleep(0.04)
            try:
                there, back = await asyncio.open_connection("127.0.0.1", port)
            except OSError:
                return writer.close()
            await asyncio.gather(up.carry(reader, back), down.carry(there, writer), return_exceptions=True)

        server = await asyncio.start_server(connect, "127.0.0.1", 0)
        found.append(server.sockets[0].getsockname()[1])
        await server.serve_forever()

    threading.Thread(target=lambda: asyncio.run(serve()), daemon=True).start()
    while not found:
        time.sleep(0.01)
    return found[0]


def mean(frames, key):
    return sum(frame[key] for frame in frames) / len(frames)


def watch(page, scene):
    while not page.evaluate("!!window.phalanx?.frame"):
        time.sleep(0.05)
    page.keyboard.press("h")
    page.evaluate("phalanx.idle()")
    page.evaluate(RECORD)
    x, y = WINDOW["width"] / 2, WINDOW["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    start = time.monotonic()
    while (turn := 1.2 * (time.monotonic() - start)) < 1.2 * SECONDS:
        page.mouse.move(x + 100 * math.sin(turn), y + 30 * math.sin(0.7 * turn))
        time.sleep(0.008)
    still = page.evaluate("performance.now()")
    page.mouse.up()
    page.evaluate("phalanx.idle()")
    time.sleep(0.4)
    drawn, latency = page.evaluate("[drawn, phalanx.latency]")
    moving = [frame for frame in drawn if frame["moving"]]
    moving = [frame for frame in moving if frame["at"] > moving[0]["at"] + 1000]
    resting = [frame for frame in drawn if not frame["moving"] and frame["at"] > still]
    return {
        "scene": scene.rsplit("/", 1)[-1],
        "frames_per_s": round(1000 * (len(moving) - 1) / (moving[-1]["at"] - moving[0]["at"]), 1),
        "size": [round(mean(moving, "width")), round(mean(moving, "height"))],
        "bounces": round(mean(moving, "max_depth"), 1),
        "work_ms": round(mean(moving, "ms"), 1),
        "mrays_per_s": round(sum(sum(frame["rays"].values()) for frame in moving) / sum(frame["ms"] for frame in moving) / 1e3, 1),
        "kernels": sorted({frame["kernel"] for frame in moving}),
        "latency_ms": [round(latency[key], 1) for key in ("median", "p99")],
        "full_size_ms": round(resting[0]["at"] - still),
        f"samples_{SAMPLES}_ms": round(next(f["at"] for f in resting if f["samples"] >= SAMPLES) - still),
    }


def main():
    program, *scenes = [word for word in sys.argv[1:] if word != "--slow"]
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=["--no-sandbox"])
        for scene in scenes:
            line = [program, "view", scene, "--spp", str(SAMPLES)]
            served = subprocess.Popen(line, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
            url = served.stdout.readline().strip()
            if "--slow" in sys.argv:
                url = re.sub(r":(\d+)/", lambda port: f":{slow_port(int(port[1]))}/", url, count=1)
            # The page forbids what evaluation in it needs.
            page = browser.new_context(bypass_csp=True, viewport=WINDOW).new_page()
            page.goto(url)
            print(json.dumps(watch(page, scene)), flush=True)
            page.close()
            served.kill()


if __name__ == "__main__":
    main()
