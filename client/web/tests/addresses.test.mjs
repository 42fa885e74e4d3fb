// Which server the page connects to, what it says of one that will not do, and the view that it keeps in its address.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { openSources } from './support.mjs';

let sources, readAddress, serverAddress, KeptAddress, viewText, queryText;
before(async () => {
  sources = await openSources();
  ({ readAddress } = await sources.load('ui/settings.ts'));
  ({ serverAddress } = await sources.load('ui/server_address.ts'));
  ({ KeptAddress, viewText, queryText } = await sources.load('ui/kept_address.ts'));
});
after(() => sources?.close());

test('the page connects beside its own address', () => {
  for (const [page, url] of [
    ['http://127.0.0.1:8080/', 'ws://127.0.0.1:8080/fly'],
    ['http://maps.example/terrain/', 'ws://maps.example/terrain/fly'],
    ['https://maps.example/a/b/index.html?tau=2&view=1,2#token=x', 'wss://maps.example/a/b/fly'],
    ['https://[2001:db8::1]:8443/?server', 'wss://[2001:db8::1]:8443/fly'],
  ]) assert.deepEqual(serverAddress(null, page), { url }, page);
});

test('an address of a server is taken in any of its forms', () => {
  const page = 'http://127.0.0.1:8080/';
  for (const [wanted, url] of [
    ['ws://a.example:8080/fly', 'ws://a.example:8080/fly'],
    ['ws://a.example:8080', 'ws://a.example:8080/fly'],
    ['wss://a.example/terrain/', 'wss://a.example/terrain/fly'],
    ['http://a.example:8080/', 'ws://a.example:8080/fly'],
    ['https://a.example/deep/socket?x=1#y', 'wss://a.example/deep/socket?x=1'],
    ['ws://[::1]:8080/', 'ws://[::1]:8080/fly'],
  ]) assert.deepEqual(serverAddress(wanted, page), { url }, wanted);
});

test('an address without a scheme is named, with what to write', () => {
  for (const [wanted, page, better] of [
    ['host:8080', 'http://a.example/', 'ws://host:8080/fly'],
    ['localhost:8080/fly', 'http://a.example/', 'ws://localhost:8080/fly'],
    ['127.0.0.1:8080', 'https://a.example/', 'wss://127.0.0.1:8080/fly'],
    ['//maps.example/terrain/', 'https://a.example/', 'wss://maps.example/terrain/fly'],
    ['[::1]:8080', 'http://a.example/', 'ws://[::1]:8080/fly'],
    ['nowhere', 'http://a.example/', 'ws://nowhere/fly'],
  ]) {
    const said = serverAddress(wanted, page);
    assert.equal(said.better, better);
    assert.ok(said.text.includes(`"${wanted}"`) && said.text.includes(better), said.text);
  }
  for (const wanted of ['', 'ftp://a.example/', 'ws://', 'a b', 'javascript:alert(1)', '../fly', 'ws://a:99999']) {
    const said = serverAddress(wanted, 'http://a.example/');
    assert.equal(said.better, null, wanted);
    assert.match(said.text, /wss:\/\/example\.org\/fly/);
  }
});

test('a page of https that is to connect without TLS says so, unless the server is on this machine', () => {
  const page = 'https://a.example/';
  for (const wanted of ['ws://b.example:8080', 'http://b.example:8080/fly']) {
    const said = serverAddress(wanted, page);
    assert.match(said.text, /https.*wss: alone.*ws:\/\/b\.example:8080\/fly.*--tls-cert/);
    assert.equal(said.better, 'wss://b.example:8080/fly');
  }
  for (const host of ['localhost:1', '127.0.0.1:1', '[::1]:1', 'x.localhost:1'])
    assert.deepEqual(serverAddress(`ws://${host}`, page), { url: `ws://${host}/fly` });
  assert.ok(serverAddress('ws://127.0.0.1.example', page).better);
});

test('an area is read where a place is, and if it is one', () => {
  const areaOf = (search) => readAddress({ search, hash: '' }, 'ws://a/fly').area;
  for (const place of ['view=1,2,3,4,5', 'at=46,7']) {
    for (const area of ['0', '17', '402653183']) assert.equal(areaOf(`?area=${area}&${place}`), area);
    for (const bad of ['', '-1', '1.5', '1e3', 'x', '1234567890', '%0a1', '1%20', '1%00']) assert.equal(areaOf(`?${place}&area=${bad}`), null, bad);
    assert.equal(areaOf(`?${place}`), null);
  }
  assert.equal(areaOf('?area=17'), null, 'the page would begin elsewhere');
});

test('the address changes twice a second at most, and not at all while the view rests', () => {
  const written = [];
  const kept = new KeptAddress((query) => written.push(query));
  kept.begin('?view=0');
  for (let ms = 0; ms < 3000; ms += 16) kept.keep(ms, () => '?view=0');
  assert.deepEqual(written, []);
  for (let ms = 3000; ms < 33_000; ms += 16) kept.keep(ms, () => `?view=${ms}`);
  assert.ok(written.length > 50 && written.length <= 61, `${written.length} changes in 30 s`);
  kept.keep(34_000, () => '?view=last');
  for (let ms = 34_016; ms < 40_000; ms += 16) kept.keep(ms, () => '?view=last');
  assert.equal(written.at(-1), '?view=last', 'where it came to rest');
  assert.ok(written.length <= 62);
});

test('a browser that refuses to change the address is not asked again', () => {
  let asked = 0;
  const kept = new KeptAddress(() => {
    ++asked;
    throw new Error('SecurityError');
  });
  for (let ms = 0; ms < 5000; ms += 100) kept.keep(ms, () => `?view=${ms}`);
  assert.equal(asked, 1);
});

test('a view is written as finely as its scene needs, and short', () => {
  assert.equal(viewText([1234.56, -0.001, 800], { heading: 2 * Math.PI + 0.1, pitch: -0.2 }, 15_000), '1234.6,0.0,800.0,5.730,-11.459');
  assert.equal(viewText([1.23456, 2, 3], { heading: -Math.PI / 2, pitch: 0 }, 4), '1.23456,2.00000,3.00000,-90.000,0.000');
  assert.equal(queryText(new URLSearchParams({ server: 'ws://a.example:1/fly', view: '1,2,3,4,5' })), '?server=ws://a.example:1/fly&view=1,2,3,4,5');
  assert.equal(queryText(new URLSearchParams({ colours: 'a&b=c#d' })), '?colours=a%26b%3Dc%23d');
  assert.equal(queryText(new URLSearchParams()), '');
});
