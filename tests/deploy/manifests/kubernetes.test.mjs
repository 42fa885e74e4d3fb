// The objects of deploy/kubernetes are of Kubernetes' schemas, and agree with each other and with what servers and
// HAProxy listen on.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdtemp, readFile, rm, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';

import * as yaml from 'js-yaml';

const deploy = new URL('../../../deploy/', import.meta.url);
const text = await readFile(new URL('kubernetes/foreland.yaml', deploy), 'utf8');
const objects = yaml.loadAll(text);
const of = (kind, name) => objects.find((object) => object.kind === kind && object.metadata.name === name);

// What Kubernetes has against objects: by their schemas, and names that it does not know, which schemas let pass, by the types of
// TypeScript that are made of them.
async function faults(objects) {
  const found = [];
  const lines = [];
  for (const [i, object] of objects.entries()) {
    const { apiVersion, kind } = object;
    const Model = (await import(`kubernetes-models/${apiVersion}/${kind}`))[kind];
    try {
      new Model(object).validate();
    } catch (error) {
      found.push(`${kind}: ${error.message}`);
    }
    lines.push(`import type { I${kind} as Object${i} } from 'kubernetes-models/${apiVersion}/${kind}';`);
    lines.push(`export const object${i}: Object${i} = ${JSON.stringify(object)};`);
  }
  return [...found, ...await typeErrors(lines.join('\n'))];
}

async function typeErrors(source) {
  const folder = await mkdtemp(fileURLToPath(new URL('.types-', import.meta.url))); // here, where the packages are found
  try {
    const file = join(folder, 'objects.mts');
    await writeFile(file, source);
    const tsc = fileURLToPath(new URL('node_modules/.bin/tsc', import.meta.url));
    const { status, stdout } = spawnSync(tsc, ['--noEmit', '--strict', '--skipLibCheck', '--module', 'nodenext', '--ignoreConfig', file]);
    return status === 0 ? [] : [String(stdout)];
  } finally {
    await rm(folder, { recursive: true });
  }
}

test('all objects are of their schemas', async () => {
  assert.equal(objects.length, 6);
  assert.deepEqual(await faults(objects), []);
});

test('a wrong name, a wrong type and a missing field are found', async () => {
  const mistakes = [
    ['readOnlyRootFilesystem', 'readOnlyRootFilesystm'],
    ['failureThreshold: 60', 'failureThreshold: many'],
    ['  maxReplicas: 64', '  '],
    ['metric: {name: foreland_pool_load}\n', ''],
  ];
  for (const [right, wrong] of mistakes) {
    assert.ok(text.includes(right));
    assert.notDeepEqual(await faults(yaml.loadAll(text.replace(right, wrong))), [], wrong);
  }
});

test('services, budget and spread select the pods that the sets make', () => {
  const labels = (kind, name) => of(kind, name).spec.template.metadata.labels;
  const servers = labels('StatefulSet', 'foreland');
  assert.deepEqual(of('Service', 'foreland-servers').spec.selector, servers);
  assert.deepEqual(of('PodDisruptionBudget', 'foreland').spec.selector.matchLabels, servers);
  assert.deepEqual(of('StatefulSet', 'foreland').spec.selector.matchLabels, servers);
  assert.deepEqual(of('Service', 'foreland').spec.selector, labels('Deployment', 'foreland-proxy'));
});

test('the autoscaler counts what servers export, up to the places of HAProxy', async () => {
  const { maxReplicas, metrics, scaleTargetRef } = of('HorizontalPodAutoscaler', 'foreland').spec;
  assert.ok(of(scaleTargetRef.kind, scaleTargetRef.name));
  const alerts = await readFile(new URL('prometheus/alerts.yml', deploy), 'utf8'); // held to /metrics by monitoring_test
  assert.ok(alerts.includes(metrics[0].pods.metric.name));
  const proxy = await readFile(new URL('haproxy-fleet.cfg', deploy), 'utf8');
  for (const [, places] of proxy.matchAll(/server-template \S+ (\d+)/g)) assert.equal(Number(places), maxReplicas);
});

test('a stop has time to hand the viewers over', () => {
  const { terminationGracePeriodSeconds, containers } = of('StatefulSet', 'foreland').spec.template.spec;
  const [, seconds] = /--drain-seconds=(\d+)/.exec(containers[0].args.join(' '));
  assert.ok(terminationGracePeriodSeconds > Number(seconds));
});
