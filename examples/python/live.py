"""Live clouds of the virtual camera: a loop gets the newest ones, a callback gets all."""

import slipstream

sequence = slipstream.Sequence("pmp, steps 4")
points: list[int] = []

with slipstream.Live("virtual", sequence, on_cloud=lambda cloud: points.append(len(cloud)),
                     camera=(320, 240), rate=100, most_frames=60) as live:
    for cloud in live:
        newest = cloud  # the scene keeps moving
print(f"{len(points)} clouds, the newest of {len(newest)} points, "
      f"half of them within {live.statistics['latency_p50']:.1f} ms of capture")
