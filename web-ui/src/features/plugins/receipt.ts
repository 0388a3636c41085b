// What became of an upgrade or a roll back, in one sentence. Pure.

import type { UpgradeReceipt } from '../../protocol/types';

export function receiptText(receipt: UpgradeReceipt): { text: string; bad: boolean } {
  const failed = receipt.instances.filter((one) => one.error !== null);
  const first = failed[0];
  if (receipt.rolled_back) {
    return { text: `${receipt.name} stays ${receipt.from}: ${first ? `${first.name} did not come up (${first.error})` : 'an instance did not come up'}`, bad: true };
  }
  const changed = receipt.instances.filter((one) => one.restored === 'differently').length;
  const count = receipt.instances.length;
  const states = changed > 0 ? `, ${changed} with another state than before` : '';
  return {
    text: `${receipt.name} is ${receipt.to} now, ${count} ${count === 1 ? 'instance' : 'instances'} exchanged${states}`,
    bad: failed.length > 0,
  };
}
