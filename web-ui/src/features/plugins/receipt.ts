// What became of an upgrade or a roll back, in one sentence of the chosen language. Must never decide anything.

import { t } from '../../language/language.svelte';
import type { UpgradeReceipt } from '../../protocol/types';

export function receiptText(receipt: UpgradeReceipt): { text: string; bad: boolean } {
  const { name, from, to } = receipt;
  const failed = receipt.instances.filter((one) => one.error !== null);
  const first = failed[0];
  if (receipt.rolled_back) {
    const why = first ? t('{name} did not come up ({why})', { name: first.name, why: first.error ?? '' }) : t('an instance did not come up');
    return { text: t('{name} stays {version}: {why}', { name, version: from, why }), bad: true };
  }
  const changed = receipt.instances.filter((one) => one.restored === 'differently').length;
  const count = receipt.instances.length;
  const is = count === 1 ? t('{name} is {version} now, 1 instance exchanged', { name, version: to }) : t('{name} is {version} now, {count} instances exchanged', { name, version: to, count });
  return { text: changed > 0 ? `${is}, ${t('{count} with another state than before', { count: changed })}` : is, bad: failed.length > 0 };
}
