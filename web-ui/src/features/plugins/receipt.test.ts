import { describe, expect, it } from 'vitest';
import type { UpgradeReceipt } from '../../protocol/types';
import { receiptText } from './receipt';

const receipt = (over: Partial<UpgradeReceipt>): UpgradeReceipt => ({ name: 'gimbal', from: '0.1.0', to: '0.2.0', instances: [], rolled_back: false, ...over });

describe('what became of an upgrade', () => {
  it('counts what was exchanged', () => {
    const instances: UpgradeReceipt['instances'] = [{ name: 'a', restored: 'exactly', error: null }, { name: 'b', restored: 'differently', error: null }];
    expect(receiptText(receipt({ instances }))).toEqual({ text: 'gimbal is 0.2.0 now, 2 instances exchanged, 1 with another state than before', bad: false });
  });

  it('says what kept it from happening', () => {
    const instances: UpgradeReceipt['instances'] = [{ name: 'payload-2-gimbal', restored: null, error: 'crashed' }];
    expect(receiptText(receipt({ rolled_back: true, instances }))).toEqual({ text: 'gimbal stays 0.1.0: payload-2-gimbal did not come up (crashed)', bad: true });
  });
});
