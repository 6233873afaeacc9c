#!/usr/bin/env python3
"""A batch on a farm that is not there: when its shards would end, with nodes that fail.

    slipstream batch plan archive.txt --tasks 1000000 --plan plan -o '{name}.ply'
    tests/farms/schedule.py plan --nodes 1000 --rate 46e6 --node-hours 500 --shard-failures 0.01

Each node does one shard at a time, in the order of the plan, as Slurm does an array. A node fails
after a time that is exponentially distributed, and comes back after an hour; what its shard had
done stays done, the rest is queued again once the farm notices. A shard that fails by itself is as
well, up to three times.
"""
import argparse
import heapq
import random


def costs_of_shards(plan):
    costs = {}
    with open(plan + "/scans.txt", encoding="utf-8", errors="surrogateescape") as lines:
        for line in lines:
            _, _, cost, shard = line.rstrip("\n").split("\t")
            costs[int(shard)] = costs.get(int(shard), 0) + int(cost)
    return [cost for _, cost in sorted(costs.items())]


def simulate(costs, farm):
    """Ends, busy seconds and lost ones of all shards, and how often they were begun."""
    chance = random.Random(1)
    until_failure = lambda: chance.expovariate(1 / (3600 * farm.node_hours))
    free = [(0.0, node) for node in range(farm.nodes)]
    fails = [until_failure() for _ in range(farm.nodes)]
    queue = [(0.0, shard, cost / farm.rate, 1) for shard, cost in enumerate(costs)]
    heapq.heapify(queue)
    last = busy = lost = begun = 0
    given_up = []
    while queue:
        ready, shard, work, attempt = heapq.heappop(queue)
        now, node = heapq.heappop(free)
        start = max(now, ready)
        begun += 1
        if start >= fails[node]:  # while it was idle
            heapq.heappush(queue, (ready, shard, work, attempt))
            heapq.heappush(free, (fails[node] + farm.repair, node))
            fails[node] += farm.repair + until_failure()
            continue
        fault = chance.random() < farm.shard_failures
        takes = farm.start + work * (chance.random() if fault else 1)
        end = start + takes
        if end > fails[node]:
            takes, end = fails[node] - start, fails[node]
            heapq.heappush(free, (end + farm.repair, node))
            fails[node] += farm.repair + until_failure()
            again, attempt = end + farm.notice, attempt - 1
        else:
            heapq.heappush(free, (end, node))
            again = end if fault else None
        busy += takes
        done = max(0.0, takes - farm.start)
        kept = done if farm.resume else 0.0
        if again is None:
            last = max(last, end)
            continue
        lost += done - kept
        if attempt == 3:
            given_up.append(shard)
        else:
            heapq.heappush(queue, (again, shard, work - kept, attempt + 1))
    return last, busy, lost, begun, given_up


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("plan")
    parser.add_argument("--nodes", type=int, default=1000)
    parser.add_argument("--rate", type=float, default=46e6, help="pixels that a node does in a second")
    parser.add_argument("--node-hours", type=float, default=500, help="between failures of a node")
    parser.add_argument("--repair", type=float, default=3600, help="seconds that a node is away")
    parser.add_argument("--notice", type=float, default=300, help="seconds until that is noticed")
    parser.add_argument("--start", type=float, default=1.0, help="seconds until a shard begins")
    parser.add_argument("--shard-failures", type=float, default=0.01, help="share that fails")
    parser.add_argument("--no-resume", dest="resume", action="store_false")
    farm = parser.parse_args()
    costs = costs_of_shards(farm.plan)
    last, busy, lost, begun, given_up = simulate(costs, farm)
    ideal = sum(costs) / farm.rate / farm.nodes
    print(f"{len(costs)} shards, {begun} begun, {len(given_up)} given up; {last / 3600:.3f} h where "
          f"{ideal / 3600:.3f} h are the work alone; nodes busy {busy / last / farm.nodes:.1%}; "
          f"{lost / 3600:.1f} h of work lost")


if __name__ == "__main__":
    main()
